// What tools read off the network: datagrams, and messages of types that a source tells.
#include <algorithm>

#include "lcm_tools/diagnosis/datagram.hpp"
#include "lcm_tools/schema/decoder.hpp"
#include "lcm_tools/schema/json.hpp"
#include "lcm_tools/schema/schema.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::lcm_schema;  // NOLINT(google-build-using-namespace): all of it

MARCO_FUZZ(datagrams) {
  Input input(bytes);
  diagnosis::SequenceTracker tracker;
  diagnosis::Reassembler reassembler;
  std::vector<std::string> incomplete;
  int64_t now_us = 0;
  while (!input.empty()) {
    const auto piece = input.piece();
    const auto datagram = diagnosis::parse_datagram(piece);
    now_us += 1000;
    if (!datagram) continue;
    promise(datagram->payload.size() <= piece.size(), "a payload lies in its datagram");
    if (!datagram->fragmented) {
      tracker.add(datagram->sequence);
      continue;
    }
    tracker.add_fragment(datagram->sequence);
    const auto message = reassembler.add(*datagram, now_us, incomplete);
    if (message) promise(message->size <= (256U << 20U), "a message is below 256 MB");
    if (now_us % 7000 == 0) reassembler.give_up(now_us - 5000, incomplete);
  }
}

void put(Bytes& out, uint32_t value, unsigned bytes) {
  while (bytes-- > 0) out.push_back(static_cast<uint8_t>(value >> (8 * bytes)));
}

/// A datagram whose header fits what follows, of ten bytes and a payload: no fuzzer guesses magic,
/// lengths and offsets that belong together.
Bytes datagram_of(Input& input) {
  const uint8_t form = input.byte();
  const uint32_t jump = form % 16U == 0 ? (1U << 24U) + 7U : form % 16U == 1 ? 2000U : 0U;
  const uint32_t sequence = jump + input.byte() - (form % 16U == 2 ? 300U : 0U);
  const uint32_t fragment = input.byte() % 4U, fragments = fragment + 1U + input.byte() % 3U;
  const uint32_t size = input.byte() % 8U == 7 ? 1U << 26U : 16U * fragments;
  const auto text = input.take(1U + input.byte() % 16U);
  Bytes out;
  put(out, form < 100 ? 0x4c433032 : 0x4c433033, 4);
  put(out, sequence, 4);
  if (form >= 100) {
    put(out, size, 4);
    put(out, 16U * fragment, 4);
    put(out, fragment, 2);
    put(out, fragments, 2);
  }
  if (form < 100 || fragment == 0) {
    put(out, 'A' + form % 3U, 1);
    put(out, 0, 1);
  }
  out.insert(out.end(), text.begin(), text.end());
  return out;
}

MARCO_FUZZ(fragments) {
  Input input(bytes);
  diagnosis::SequenceTracker tracker;
  diagnosis::Reassembler reassembler;
  std::vector<std::string> incomplete;
  int64_t now_us = 0;
  while (!input.empty()) {
    const Bytes wire = datagram_of(input);
    const auto datagram = diagnosis::parse_datagram(wire);
    promise(datagram.has_value(), "a sound datagram is read");
    now_us += 1000;
    if (!datagram->fragmented) {
      tracker.add(datagram->sequence);
      promise(tracker.duplicates() >= 0 && tracker.restarts() >= 0,
              "nothing is counted below zero");
      continue;
    }
    tracker.add_fragment(datagram->sequence);
    const auto message = reassembler.add(*datagram, now_us, incomplete);
    if (message) promise(message->bytes().size() == datagram->message_bytes, "it is whole");
    if (!message) promise(reassembler.holds(datagram->sequence), "what is not whole is kept");
    if (now_us % 7000 == 0) reassembler.give_up(now_us - 5000, incomplete);
    if (now_us % 13000 == 0) tracker.forget_losses();
  }
  reassembler.give_up(now_us + 1, incomplete);
  promise(reassembler.empty(), "in the end all is given up");
  diagnosis::to_string({static_cast<uint32_t>(now_us), static_cast<uint16_t>(bytes.size())});
}

/// What a decoded tree can be asked.
void ask(const Tree& tree) {
  std::size_t values = 0;
  for_each_value(tree, [&](int node, std::size_t element) {
    if (++values >= 50) return;
    value_name(tree, node, element);
    const Node& at = tree.nodes[static_cast<std::size_t>(node)];
    if (at.primitive == Primitive::string) {
      tree.text(at);
    } else {
      tree.integer(at, element);
      tree.number(at, element);
    }
    const int found = tree.find(tree.path(node));
    promise(found >= 0, "a path leads somewhere");
  });
  promise(tree.find("no such field") < 0, "what is not there is not found");
}

MARCO_FUZZ(json_string) {
  Input input(bytes);
  std::string json;
  append_json_string(input.text(), json);
  promise(json.size() >= 2 && json.front() == '"' && json.back() == '"', "it stands in quotes");
  promise(std::all_of(json.begin(), json.end(),
                      [](char c) { return static_cast<unsigned char>(c) >= 0x20; }),
          "controls are escaped");
}

/// A source and a message: every type of the source is tried on it.
MARCO_FUZZ(lcm_schema) {
  Input input(bytes);
  const auto text = input.piece();
  const Schema schema({{"fuzz/fuzz.lcm", std::string(text.begin(), text.end())}});
  const Decoder decoder(schema);
  Tree tree;
  const auto rest = input.rest();
  std::string json;
  for (int i = 0; i < static_cast<int>(schema.structures().size()) && i < 8; ++i) {
    const Structure& structure = schema.structures()[static_cast<std::size_t>(i)];
    if (!structure.complete || structure.is_enum) continue;
    Bytes message(8);
    for (unsigned byte = 0; byte < 8; ++byte) {
      message[byte] = static_cast<uint8_t>(structure.fingerprint >> (56U - 8U * byte));
    }
    message.insert(message.end(), rest.begin(), rest.end());
    const DecodeStatus checked = decoder.check(i, message);
    const DecodeStatus status = decoder.decode(i, message, tree);
    promise((checked == DecodeStatus::ok) == (status == DecodeStatus::ok) ||
                status == DecodeStatus::too_large || checked == DecodeStatus::too_large,
            "check and decode agree");
    promise(name_of(status)[0] != '\0', "a status has a name");
    message[0] = static_cast<uint8_t>(message[0] ^ 1U);
    promise(decoder.check(i, message) == DecodeStatus::wrong_fingerprint &&
                name_of(DecodeStatus::wrong_fingerprint)[0] != '\0',
            "a message of another type is refused");
    message[0] = static_cast<uint8_t>(message[0] ^ 1U);
    if (status != DecodeStatus::ok) continue;
    for (const JsonOptions& options : {JsonOptions{true, 100}, JsonOptions{false, 3}}) {
      json.clear();
      append_json(tree, json, options);
      json_schema(schema, i, options);
    }
    ask(tree);
    const auto same = schema.with_fingerprint(fingerprint_of(message).value_or(0));
    // The same type told twice counts once.
    promise(std::any_of(same.begin(), same.end(),
                        [&](int other) {
                          return schema.structures()[static_cast<std::size_t>(other)].name ==
                                 structure.name;
                        }),
            "found by its fingerprint");
    promise(schema.find(structure.name).has_value(), "found by its name");
  }
}

/// Sources as files of two folders: types of one name, of which the nearest is meant.
MARCO_FUZZ(lcm_files) {
  Input input(bytes);
  const TemporaryFolder folder;
  const int files = 1 + input.byte() % 4;
  std::filesystem::create_directory(folder.path() / "other");
  for (int i = 0; i < files; ++i) {
    const std::string name = std::to_string(i) + (i == 3 ? ".txt" : ".lcm");
    const auto text = i + 1 == files ? input.rest() : input.piece();
    write_file((i == 1 ? folder.path() / "other" : folder.path()) / name, text);
  }
  std::vector<Problem> problems;
  const std::vector<Source> sources = read_sources(folder.path(), problems);
  promise(static_cast<int>(sources.size()) == std::min(files, 3), "each source is read, no other");
  promise(read_sources(folder.path() / "0.lcm", problems).size() == 1, "a file is a source");
  const std::size_t before = problems.size();
  promise(
      read_sources(folder.path() / "none.lcm", problems).empty() && problems.size() == before + 1,
      "a file that is not there is a problem");
  const Schema schema(sources);
  for (const Structure& structure : schema.structures()) {
    const std::size_t dot = structure.name.rfind('.');
    schema.find(structure.name.substr(dot == std::string::npos ? 0 : dot + 1));
    promise(!schema.find(structure.name + "?"), "no type has such a name");
    for (const Member& member : structure.members) {
      if (!member.primitive) continue;
      promise(name_of(*member.primitive)[0] != 0 && wire_bytes(*member.primitive) <= 8,
              "a primitive has a name and a size");
    }
  }
}

}  // namespace
}  // namespace marco::fuzz
