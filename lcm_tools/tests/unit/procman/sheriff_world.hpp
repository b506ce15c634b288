#pragma once

#include <csignal>
#include <string>
#include <vector>

#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

inline constexpr int64_t kSecondUs = 1'000'000;

inline constexpr char kRobot[] = R"(
cmd "logger" { exec = "logger"; deputy = "base"; }
group "drivers" {
  cmd "lidar" { exec = "lidar"; deputy = "base"; environment = "A=1"; }
  group "cameras" { cmd "left" { exec = "cam"; deputy = "base"; } }
}
script "go" {
  start group "drivers" wait "running";
  wait ms 500;
  run_script "inner";
  stop everything wait "stopped";
}
script "inner" { start cmd "logger" wait publishing "LOG" timeout ms 2000 then abort; }
script "lenient" { start cmd "logger" wait publishing "LOG" timeout ms 2000 then continue; stop cmd "logger"; }
)";

/// A sheriff and a deputy that really talk (through values), under one clock.
struct SheriffWorld {
  explicit SheriffWorld(bool deputy_is_there = true) : sheriff("sheriff-1") {
    config = parse_config(kRobot, "robot.procman");
    sheriff.load(config);
    if (deputy_is_there) info();
  }
  void info() {
    const auto lines = sheriff.on_info({now_us, "base", {}, deputy.commands()}, now_us, now_us);
    events.insert(events.end(), lines.begin(), lines.end());
  }
  /// Orders go out, commands start and stop at once, the deputy answers.
  void exchange() {
    for (const Orders& orders : sheriff.take_due_orders(now_us, now_us)) {
      ++orders_sent;
      deputy.on_orders(orders, now_us, now_us);
    }
    for (bool again = true; again;) {
      again = false;
      for (const DeputyAction& action : deputy.take_actions()) {
        again = true;
        if (const auto* start = std::get_if<StartCommand>(&action)) {
          deputy.on_started(start->spec.id, ++last_pid);
        } else if (const auto* stop = std::get_if<StopCommand>(&action)) {
          deputy.on_ended(stop->id, SIGINT, now_us);
        }
      }
    }
    if (deputy.take_changed()) info();
  }
  void pass(int64_t us) {
    now_us += us;
    exchange();
  }
  Status status(const std::string& id) { return sheriff.commands().at(id).status(); }

  Config config;
  SheriffState sheriff;
  DeputyState deputy{{"base", std::nullopt}};
  int64_t now_us = 100 * kSecondUs;
  int32_t last_pid = 10;
  int orders_sent = 0;
  std::vector<std::string> events;
};

}  // namespace marco::procman
