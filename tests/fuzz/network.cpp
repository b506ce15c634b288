// What tools read off the network: datagrams, and messages of types that a source tells.
#include "common/lcm_schema/decoder.hpp"
#include "common/lcm_schema/json.hpp"
#include "common/lcm_schema/schema.hpp"
#include "tests/fuzz/target.hpp"
#include "tools/spy/datagram.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::lcm_schema;  // NOLINT(google-build-using-namespace): all of it

MARCO_FUZZ(datagrams) {
  Input input(bytes);
  spy::SequenceTracker tracker;
  spy::Reassembler reassembler;
  std::vector<std::string> incomplete;
  int64_t now_us = 0;
  while (!input.empty()) {
    const auto piece = input.piece();
    const auto datagram = spy::parse_datagram(piece);
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
    if (status != DecodeStatus::ok) continue;
    json.clear();
    append_json(tree, json, {true, 100});
    std::size_t values = 0;
    for_each_value(tree, [&](int node, std::size_t element) {
      if (++values < 50) value_name(tree, node, element);
    });
    json_schema(schema, i);
  }
}

}  // namespace
}  // namespace marco::fuzz
