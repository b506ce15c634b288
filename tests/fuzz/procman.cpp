// What strangers tell sheriffs and deputies, what keepers and deputies say to each other, and files
// that people write for them.
#include <set>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/exec_line.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"
#include "lcm_tools/procman/utf8.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::procman;  // NOLINT(google-build-using-namespace): all of it

constexpr int64_t kWallUs = 1'600'000'000'000'000;

template <class Message>
bool checked(std::span<const uint8_t> bytes, const char* layout, Message& message) {
  Bytes whole(8);
  const auto hash = static_cast<uint64_t>(Message::getHash());
  for (unsigned i = 0; i < 8; ++i) whole[i] = static_cast<uint8_t>(hash >> (56U - 8U * i));
  whole.insert(whole.end(), bytes.begin(), bytes.end());
  const int size = static_cast<int>(whole.size());
  return is_well_formed(whole, layout) && message.decode(whole.data(), 0, size) == size;
}

/// The same message with this host's own decoder only, as plain subscribers meet it.
template <class Message>
void unchecked(std::span<const uint8_t> bytes) {
  Message message{};
  checked(bytes, "", message);
  Bytes whole(8);
  const auto hash = static_cast<uint64_t>(Message::getHash());
  for (unsigned i = 0; i < 8; ++i) whole[i] = static_cast<uint8_t>(hash >> (56U - 8U * i));
  whole.insert(whole.end(), bytes.begin(), bytes.end());
  const int size = static_cast<int>(whole.size());
  promise(message.decode(whole.data(), 0, size) <= size, "reads no more than there is");
}

void as_orders(std::span<const uint8_t> bytes) {
  procman_lcm::orders_t message{};
  if (!checked(bytes, layouts::kOrders, message)) return;
  Orders orders = from_message(message);
  SheriffState sheriff("me", true);
  sheriff.on_orders(orders);
  DeputyOptions options;
  options.deputy_id = orders.deputy_id = "here";
  options.allowed_execs = std::set<std::string>{"allowed"};
  DeputyState deputy(options);
  deputy.on_orders(orders, kWallUs, 0);
  orders.utime_us = kWallUs;
  deputy.on_orders(orders, kWallUs, 0);
  for (const DeputyAction& action : deputy.take_actions()) {
    const auto* start = std::get_if<StartCommand>(&action);
    if (start == nullptr) continue;
    promise(start->spec.exec == "allowed", "a deputy starts only what its script holds");
    deputy.on_started(start->spec.id, 1);
    deputy.on_ended(start->spec.id, 0, 1);
  }
  deputy.on_time(1'000'000);
  to_message(orders);
}

void as_info(std::span<const uint8_t> bytes) {
  procman_lcm::deputy_info_t message{};
  if (!checked(bytes, layouts::kInfo, message)) return;
  DeputyInfo info = from_message(message);
  SheriffState sheriff("me");
  sheriff.on_info(info, kWallUs, 0);
  info.utime_us = kWallUs;
  sheriff.on_info(info, kWallUs, 0);
  const SheriffState before = sheriff;
  for (const auto& [id, command] : before.commands()) sheriff.start(id);
  for (const auto& [id, command] : sheriff.commands()) describe_exit(command.reported->exit_code);
  sheriff.take_due_orders(kWallUs, 2'000'000);
  to_message(info);
}

MARCO_FUZZ(procman_messages) {
  Input input(bytes);
  const uint8_t type = input.byte();
  const auto rest = input.rest();
  switch (type % 8) {
    case 0:
      return as_orders(rest);
    case 1:
      return as_info(rest);
    case 2: {
      procman_lcm::output_t message{};
      checked(rest, layouts::kOutput, message);
      return;
    }
    case 3: {
      procman_lcm::output_span_t message{};
      checked(rest, layouts::kOutputSpan, message);
      return;
    }
    case 4: {
      procman_lcm::discovery_t message{};
      checked(rest, layouts::kDiscover, message);
      return;
    }
    case 5:
      return unchecked<procman_lcm::deputy_info_t>(rest);
    case 6:
      return unchecked<procman_lcm::orders_t>(rest);
    default:
      return unchecked<procman_lcm::output_t>(rest);
  }
}

MARCO_FUZZ(keeper_message) {
  const std::string text(bytes.begin(), bytes.end());
  const auto message = decode_keeper_message(text);
  if (message) promise(decode_keeper_message(encode(*message)) == message, "reads what it wrote");
}

/// What processes write, in pieces.
MARCO_FUZZ(utf8) {
  Input input(bytes);
  Utf8Cleaner cleaner;
  std::string text;
  while (!input.empty()) {
    const auto piece = input.take(1U + input.byte() % 16U);
    text += cleaner.clean(std::string(piece.begin(), piece.end()));
  }
  text += cleaner.flush();
  promise(text.find('\0') == std::string::npos, "no zeros");
  Utf8Cleaner again;
  promise(again.clean(text) + again.flush() == text, "what is clean stays as it is");
}

MARCO_FUZZ(procman_config) {
  const std::string text(bytes.begin(), bytes.end());
  try {
    const Config config = parse_config(text, "fuzz");
    find_mistakes(config);
    find_script_mistakes(config);
    promise(parse_config(print_config(config), "printed") == config, "reads what it printed");
    Config unique = config;
    make_ids_unique(unique);
    std::set<std::string> ids;
    for (const PlacedCommand& placed : all_commands(unique)) {
      promise(placed.command.id.empty() || ids.insert(placed.command.id).second, "ids are unique");
    }
    for (const PlacedCommand& placed : all_commands(config)) {
      parse_exec_line(placed.command.wire_exec(), [](const std::string&) { return std::nullopt; });
    }
  } catch (const ConfigError&) {
  }
}

MARCO_FUZZ(exec_line) {
  const std::string text(bytes.begin(), bytes.end());
  const auto all_known = [](const std::string& name) -> std::optional<std::string> { return name; };
  const ExecLine line = parse_exec_line(text, all_known);
  for (const std::string& word : split_words(text)) {
    const std::vector<std::string> again = split_words(quote_word(word));
    promise(again.size() == 1 && again[0] == word, "a quoted word is read back");
  }
  is_only_assignments(text);
}

}  // namespace
}  // namespace marco::fuzz
