#include "procman/sheriff_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <limits>

#include "procman/command_table.hpp"
#include "procman/deputy_state.hpp"
#include "procman/script_runner.hpp"

namespace marco::procman {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using State = ScriptRunner::State;

constexpr int64_t kSecondUs = 1'000'000;

const char* const kRobot = R"(
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

TEST(SheriffState, OrdersGoOnlyToDeputiesHeardAtOnceAfterAChangeAndElseEachSecond) {
  SheriffWorld world(false);
  world.exchange();
  EXPECT_EQ(world.orders_sent, 0);
  world.info();
  world.exchange();
  EXPECT_EQ(world.orders_sent, 1);
  world.pass(kSecondUs / 2);
  EXPECT_EQ(world.orders_sent, 1);
  world.sheriff.start("lidar");
  world.exchange();
  EXPECT_EQ(world.orders_sent, 2);
  EXPECT_EQ(world.status("lidar"), Status::running);
  world.pass(kSecondUs);
  EXPECT_EQ(world.orders_sent, 3);
}

TEST(SheriffState, ACommandGoesThroughItsLife) {
  SheriffWorld world;
  EXPECT_EQ(SheriffWorld(false).status("lidar"), Status::unknown);
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  world.sheriff.start("lidar");
  EXPECT_EQ(world.status("lidar"), Status::starting);
  world.exchange();
  EXPECT_EQ(world.status("lidar"), Status::running);
  world.sheriff.restart("lidar");
  EXPECT_EQ(world.status("lidar"), Status::restarting);
  world.exchange();
  EXPECT_EQ(world.status("lidar"), Status::running);
  EXPECT_EQ(world.sheriff.commands().at("lidar").reported->actual_runid, 2);
  world.sheriff.stop("lidar");
  EXPECT_EQ(world.status("lidar"), Status::stopping);
  world.exchange();
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  world.sheriff.start("lidar");
  world.exchange();
  world.deputy.on_ended("lidar", 3 << 8, world.now_us);
  world.exchange();
  EXPECT_EQ(world.status("lidar"), Status::stopped_error);
  EXPECT_THAT(world.events, Contains("lidar: Stopped (Error), exit 3"));
  EXPECT_TRUE(world.sheriff.commands().at("lidar").force_quit) << "or a new deputy would run it";
}

TEST(SheriffState, StartingWhatRunsChangesNothing) {
  SheriffWorld world;
  world.sheriff.start("lidar");
  world.exchange();
  world.sheriff.start("lidar");
  EXPECT_EQ(world.status("lidar"), Status::running);
}

// A config loaded while its commands run already must not start them again.
TEST(SheriffState, WhatRunsAlreadyIsTakenOver) {
  SheriffWorld first;
  first.sheriff.start("lidar");
  first.exchange();
  SheriffWorld second(false);
  second.deputy = std::move(first.deputy);
  second.sheriff.start("lidar");
  EXPECT_EQ(second.status("lidar"), Status::unknown);
  second.info();
  second.exchange();
  EXPECT_EQ(second.status("lidar"), Status::running);
  EXPECT_EQ(second.sheriff.commands().at("lidar").reported->pid, 11) << "still the first process";
  second.sheriff.restart("lidar");
  second.exchange();
  EXPECT_EQ(second.sheriff.commands().at("lidar").reported->actual_runid, 2);
}

// Each would restart it to its own run id, for ever.
TEST(SheriffState, TwoSheriffsDoNotFight) {
  SheriffWorld world;
  SheriffState other("sheriff-2");
  other.load(world.config);
  const auto both = [&] {
    for (int second = 0; second < 5; ++second) {
      world.pass(kSecondUs);
      other.on_info({world.now_us, "base", {}, world.deputy.commands()}, world.now_us,
                    world.now_us);
      for (const Orders& orders : other.take_due_orders(world.now_us, world.now_us)) {
        world.deputy.on_orders(orders, world.now_us, world.now_us);
      }
      world.exchange();
    }
  };
  both();
  world.sheriff.start("lidar");
  both();
  EXPECT_EQ(world.status("lidar"), Status::running);
  world.sheriff.restart("lidar");
  both();
  EXPECT_EQ(world.sheriff.commands().at("lidar").reported->pid, 12) << "two starts, no more";
  other.stop("lidar");
  both();
  EXPECT_EQ(world.deputy.commands().at(1).pid, 0);
}

TEST(SheriffState, CommandsOfOthersAreAdopted) {
  SheriffWorld world;
  world.deputy.adopt({"foreign", "x"}, 5, 99, 0);
  world.info();
  EXPECT_EQ(world.status("foreign"), Status::running);
  world.exchange();
  EXPECT_EQ(world.status("foreign"), Status::running);
}

TEST(SheriffState, ADeputyStartedAnewRunsAgainWhatRan) {
  SheriffWorld world;
  world.sheriff.start("lidar");
  world.exchange();
  world.deputy = DeputyState({"base", std::nullopt});
  world.info();
  EXPECT_EQ(world.status("lidar"), Status::starting);
  world.pass(kSecondUs);
  EXPECT_EQ(world.status("lidar"), Status::running);
  EXPECT_EQ(world.status("logger"), Status::stopped_ok);
}

TEST(SheriffState, AnObserverLearnsAndStaysSilent) {
  SheriffWorld world;
  world.sheriff.set_observer(true);
  world.sheriff.start("lidar");
  world.exchange();
  EXPECT_EQ(world.orders_sent, 0);
  const bool foreign =
      world.sheriff.on_orders({0, "base", "other", {{{"lidar", "lidar"}, 7, false}}});
  EXPECT_TRUE(foreign);
  EXPECT_EQ(world.sheriff.commands().at("lidar").desired_runid, 7);
  EXPECT_FALSE(world.sheriff.on_orders({0, "base", "sheriff-1", {}}));
}

TEST(SheriffState, OldInformationIsIgnored) {
  SheriffWorld world(false);
  world.sheriff.on_info({world.now_us - 31 * kSecondUs, "base", {}, {}}, world.now_us, 0);
  EXPECT_THAT(world.sheriff.deputies(), IsEmpty());
}

TEST(SheriffState, TargetsMeanGroupsWithTheirSubgroups) {
  const SheriffWorld world;
  EXPECT_THAT(world.sheriff.commands_of({TargetKind::group, "drivers"}),
              ElementsAre("left", "lidar"));
  EXPECT_THAT(world.sheriff.commands_of({TargetKind::command, "left"}), ElementsAre("left"));
  EXPECT_THAT(world.sheriff.commands_of({}), SizeIs(3));
}

TEST(ScriptRunner, RunsEveryActionInItsTurn) {
  SheriffWorld world;
  ScriptRunner script(world.config, "go");
  const auto step = [&](int64_t pass_us) {
    world.pass(pass_us);
    return script.step(world.sheriff, world.now_us);
  };
  EXPECT_THAT(script.channels(), ElementsAre("LOG"));
  EXPECT_EQ(step(0), State::running);
  EXPECT_EQ(world.status("lidar"), Status::starting);
  EXPECT_EQ(script.waiting_for(), "group \"drivers\" to run");
  step(1000);  // running; then a pause until 0.1 s after the action began
  EXPECT_EQ(script.next_due_us(), 100 * kSecondUs + 100'000);
  step(100'000);  // wait ms 500
  EXPECT_EQ(world.status("logger"), Status::stopped_ok);
  EXPECT_EQ(script.next_due_us(), world.now_us + 500'000);
  step(500'000);  // run_script: logger is started
  EXPECT_EQ(world.status("logger"), Status::starting);
  step(1000);
  EXPECT_EQ(script.waiting_for(), "cmd \"logger\" to publish LOG");
  script.on_message("LOG", world.now_us);
  step(1000);
  step(100'000);  // stop everything
  EXPECT_EQ(world.status("left"), Status::stopping);
  step(1000);
  EXPECT_EQ(step(100'000), State::finished);
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  EXPECT_THAT(script.take_events(), Contains("run_script \"inner\""));
}

TEST(ScriptRunner, AMessageFromBeforeTheActionDoesNotCount) {
  SheriffWorld world;
  ScriptRunner script(world.config, "inner");
  script.on_message("LOG", world.now_us - 1);
  script.step(world.sheriff, world.now_us);
  world.pass(1000);
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::running);
  EXPECT_NE(script.waiting_for(), "");
}

TEST(ScriptRunner, ATimeoutAbortsOrContinuesAsTheScriptSays) {
  SheriffWorld world;
  ScriptRunner strict(world.config, "inner");
  strict.step(world.sheriff, world.now_us);
  world.pass(1000);
  strict.step(world.sheriff, world.now_us);
  EXPECT_EQ(strict.next_due_us(), 102 * kSecondUs);
  world.pass(2 * kSecondUs);
  EXPECT_EQ(strict.step(world.sheriff, world.now_us), State::aborted);
  EXPECT_THAT(
      strict.take_events(),
      Contains(HasSubstr("waited 2000 ms in vain for cmd \"logger\" to publish LOG (robot")));
  ScriptRunner lenient(world.config, "lenient");
  lenient.step(world.sheriff, world.now_us);
  world.pass(2 * kSecondUs);
  EXPECT_EQ(lenient.step(world.sheriff, world.now_us), State::finished);
  EXPECT_EQ(world.status("logger"), Status::stopping);
}

TEST(ScriptRunner, WhatHasEndedCannotPublish) {
  SheriffWorld world;
  ScriptRunner script(world.config, "inner");
  script.step(world.sheriff, world.now_us);
  world.pass(1000);
  world.deputy.on_ended("logger", 1 << 8, world.now_us);
  world.exchange();
  EXPECT_EQ(script.step(world.sheriff, world.now_us), State::aborted);
}

TEST(ScriptRunner, AnUnknownNameIsRefused) {
  SheriffWorld world;
  EXPECT_THROW(ScriptRunner(world.config, "none"), std::invalid_argument);
}

TEST(CommandTable, ShowsGroupsWithWhatTheirMembersHaveInCommon) {
  SheriffWorld world;
  world.sheriff.start("lidar");
  world.exchange();
  const std::vector<TableRow> rows = table_rows(world.sheriff, {}, world.now_us);
  ASSERT_THAT(rows, SizeIs(5));
  EXPECT_EQ(rows[0].name, "logger");
  EXPECT_EQ(rows[1].target, "drivers");
  EXPECT_EQ(rows[1].status, "Mixed");
  EXPECT_EQ(rows[1].colour, StatusColour::yellow);
  EXPECT_EQ(rows[1].deputy, "base");
  EXPECT_EQ(rows[2].name, "lidar");
  EXPECT_EQ(rows[2].colour, StatusColour::green);
  EXPECT_EQ(rows[3].target, "drivers/cameras");
  EXPECT_EQ(rows[3].depth, 1);
  EXPECT_EQ(rows[3].status, "Stopped (OK)");
  const std::vector<TableRow> folded = table_rows(world.sheriff, {"drivers"}, world.now_us);
  ASSERT_THAT(folded, SizeIs(2));
  EXPECT_EQ(folded[1].status, "Mixed") << "a folded group still tells of its members";
  const std::vector<TableRow> old = table_rows(world.sheriff, {}, world.now_us + 6 * kSecondUs);
  EXPECT_EQ(old[2].status, "Running?") << "nobody knows whether it still does";
  EXPECT_EQ(old[2].colour, StatusColour::grey);
}

TEST(SheriffState, ForgedInformationFillsNoTableAndOverflowsNoNumber) {
  SheriffState sheriff("me");
  const int64_t now_us = 1'600'000'000 * kSecondUs;
  for (int i = 0; i < 1500; ++i) {
    DeputyInfo info;
    info.utime_us = now_us;
    info.deputy_id = "forged " + std::to_string(i);
    for (int k = 0; k < 10; ++k) {
      info.commands.push_back({{std::to_string(i) + "/" + std::to_string(k), "x"}});
    }
    sheriff.on_info(info, now_us, now_us);
  }
  EXPECT_EQ(sheriff.deputies().size(), 1000U);
  EXPECT_EQ(sheriff.commands().size(), 10000U);

  SheriffState other("me");
  other.load(parse_config(kRobot, "robot.procman"));
  DeputyInfo info;
  info.deputy_id = "base";
  info.utime_us = std::numeric_limits<int64_t>::min();
  EXPECT_THAT(other.on_info(info, now_us, 0), IsEmpty());
  info.utime_us = now_us;
  info.commands.push_back({other.commands().at("logger").spec});
  info.commands[0].actual_runid = std::numeric_limits<int32_t>::max();
  other.on_info(info, now_us, 0);
  other.start("logger");
  EXPECT_EQ(other.commands().at("logger").desired_runid, 1);

  DeputyOptions options;
  options.deputy_id = "base";
  DeputyState deputy(options);
  Orders orders;
  orders.deputy_id = "base";
  orders.utime_us = std::numeric_limits<int64_t>::min();
  deputy.on_orders(orders, now_us, 0);
  EXPECT_EQ(deputy.refusals().stale, 1);
}

}  // namespace
}  // namespace marco::procman
