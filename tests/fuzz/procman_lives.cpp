// The lives of deputies and sheriffs: whatever is told to them, in any order.
#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::procman;  // NOLINT(google-build-using-namespace): all of it

constexpr int64_t kNowUs = 1'600'000'000'000'000;

/// One of a few ids and execs, so that orders meet commands that are there.
CommandSpec spec_from(Input& input) {
  const uint8_t choice = input.byte();
  CommandSpec spec;
  spec.id = std::string(1, static_cast<char>('a' + choice % 4U));
  spec.exec = choice % 3U == 0 ? "other" : "allowed";
  spec.auto_respawn = choice % 2U == 0;
  spec.stop_signal = choice - 100;
  spec.stop_time_allowed_s = choice % 16U == 0 ? -1.0 : choice;
  return spec;
}

/// What its hands and the network may tell a deputy, in any order.
void tell_deputy(DeputyState& deputy, Input& input, int64_t now_us) {
  const uint8_t what = input.byte();
  const CommandSpec spec = spec_from(input);
  switch (what % 8) {
    case 0:
      return deputy.on_started(spec.id, input.byte());
    case 1:
    case 2:
      return deputy.on_ended(spec.id, input.byte() + 256 * input.byte(), now_us);
    case 3:
      return deputy.adopt(spec, input.byte(), 1 + input.byte(), now_us);
    case 4:
      deputy.on_time(deputy.next_due_us().value_or(now_us));
      return;
    case 5:
      if (what > 250) deputy.shut_down();
      return;
    default:
      break;
  }
  Orders orders;
  orders.deputy_id = what > 250 ? "there" : "here";
  orders.sheriff_id = "s";
  orders.utime_us = kNowUs - (what % 32U == 7 ? 100'000'000 : 0);
  for (unsigned i = 0; i < 1U + what / 64U; ++i) {
    const uint8_t form = input.byte();
    orders.commands.push_back({spec_from(input), form / 4 - (form == 255 ? 70 : 0), form % 4 == 0});
  }
  deputy.on_orders(orders, kNowUs, now_us);
}

MARCO_FUZZ(deputy_life) {
  Input input(bytes);
  DeputyOptions options;
  options.deputy_id = "here";
  options.max_crashes = 3;
  options.max_commands = 3;
  const bool any = input.byte() % 4U == 0;
  options.allowed_execs = any ? std::nullopt : std::optional(std::set<std::string>{"allowed"});
  DeputyState deputy(options);
  int64_t now_us = 0;
  while (!input.empty()) {
    now_us += 100'000 * input.byte();
    tell_deputy(deputy, input, now_us);
    for (const DeputyAction& action : deputy.take_actions()) {
      const auto* start = std::get_if<StartCommand>(&action);
      promise(start == nullptr || any || start->spec.exec == "allowed",
              "a deputy starts only what its script holds");
      const auto* stop = std::get_if<StopCommand>(&action);
      promise(stop == nullptr || (stop->signal > 0 && stop->allowed_s >= 0.0),
              "what is stopped gets a signal, and time");
    }
    promise(deputy.commands().size() <= 4, "no more commands than there are ids");
    deputy.take_changed();
  }
  deputy.shut_down();
  deputy.shut_down();
  for (const CommandStatus& status : deputy.commands()) {
    deputy.on_ended(status.spec.id, 0, now_us);
  }
  promise(deputy.all_ended() && !deputy.next_due_us(), "after its end a deputy starts nothing");
}

/// A person's wish.
void wish(SheriffState& sheriff, const CommandSpec& spec, const std::string& deputy, uint8_t what) {
  const bool known = sheriff.commands().contains(spec.id);
  if (what % 8U == 0) {
    PlacedCommand placed;
    placed.command.id = spec.id;
    placed.command.exec = spec.exec;
    placed.command.deputy = deputy;
    placed.command.auto_respawn = spec.auto_respawn;
    sheriff.put(placed);
  }
  if (what % 8U == 1 && known) sheriff.start(spec.id);
  if (what % 8U == 2 && known) sheriff.stop(spec.id);
  if (what % 8U == 3 && known) sheriff.restart(spec.id);
  if (what % 8U == 4 && known) sheriff.remove(spec.id);
}

DeputyInfo info_from(Input& input, const std::string& deputy, uint8_t what) {
  DeputyInfo info;
  info.deputy_id = deputy;
  info.utime_us = kNowUs - (what > 250 ? 40'000'000 : 0);
  for (unsigned i = 0; i < what / 64U; ++i) {
    CommandStatus status;
    status.spec = spec_from(input);
    status.pid = input.byte() % 2;
    status.actual_runid = input.byte();
    status.exit_code = 256 * (input.byte() % 3) + input.byte() % 20;
    info.commands.push_back(status);
  }
  return info;
}

/// Wishes, deputies' reports and other sheriffs' orders, in any order.
MARCO_FUZZ(sheriff_life) {
  Input input(bytes);
  SheriffState sheriff("me", input.byte() % 8U == 0);
  int64_t now_us = 0;
  while (!input.empty()) {
    const uint8_t what = input.byte();
    const CommandSpec spec = spec_from(input);
    const uint8_t form = input.byte();
    const std::string deputy(1, static_cast<char>('x' + form % 2U));
    now_us += 100'000 * (form / 8U);
    if (what % 8U < 5) {
      wish(sheriff, spec, deputy, what);
    } else if (what % 8U == 5) {
      Orders orders;
      orders.deputy_id = deputy;
      orders.sheriff_id = form % 4U == 0 ? "me" : "other";
      orders.commands.push_back({spec, form, form % 3U == 0});
      sheriff.on_orders(orders);
      if (what > 240) sheriff.set_observer(!sheriff.observer());
    } else {
      sheriff.on_info(info_from(input, deputy, what), kNowUs, now_us);
    }
    for (const Orders& orders : sheriff.take_due_orders(kNowUs, now_us)) {
      promise(!sheriff.observer(), "who only looks orders nothing");
      for (const CommandOrder& order : orders.commands) {
        promise(sheriff.commands().contains(order.spec.id), "it orders what it has");
      }
    }
    for (const auto& [id, command] : sheriff.commands()) {
      promise(*status_text(command.status()) != 0, "a status has a name");
      command.settled();
    }
    sheriff.commands_of({TargetKind::everything, ""});
  }
}

}  // namespace
}  // namespace marco::fuzz
