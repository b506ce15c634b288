#include "lcm_tools/procman/deputy_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>

namespace marco::procman {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int64_t kSecond = 1'000'000;
constexpr int64_t kWallClock = 1'700'000'000 * kSecond;

CommandSpec lidar_spec() { return {"lidar", "lidar --fast", "drivers", false, 15, 3.0}; }

Orders orders_of(std::vector<CommandOrder> commands) {
  return {kWallClock, "base", "sheriff", std::move(commands)};
}

/// A deputy whose hands do at once what it wishes, under a clock of the test's.
struct DeputyWorld {
  explicit DeputyWorld(std::optional<std::set<std::string>> allowed = std::nullopt,
                       int max_crashes = 5)
      : deputy({"base", std::move(allowed), max_crashes}) {}

  void order(const CommandSpec& spec, int32_t runid, bool force_quit = false) {
    deputy.on_orders(orders_of({{spec, runid, force_quit}}), kWallClock, now_us);
    work();
  }
  void work() {
    for (const DeputyAction& action : deputy.take_actions()) {
      if (const auto* start = std::get_if<StartCommand>(&action)) {
        starts.push_back(*start);
        start_times_us.push_back(now_us);
        if (!slow_start) deputy.on_started(start->spec.id, ++last_pid);
      }
      if (const auto* stop = std::get_if<StopCommand>(&action)) stops.push_back(*stop);
      if (const auto* line = std::get_if<TellSheriffs>(&action)) {
        told.push_back(line->text);
        tones.push_back(line->tone);
      }
    }
  }
  void end(const std::string& id, int raw_status) {
    deputy.on_ended(id, raw_status, now_us);
    work();
  }
  /// Lets time pass until nothing is due.
  void pass_due_times() {
    while (deputy.next_due_us()) {
      now_us = *deputy.next_due_us();
      deputy.on_time(now_us);
      work();
      if (starts.size() > 100) return;
    }
  }
  CommandStatus lidar() const { return deputy.commands().at(0); }

  DeputyState deputy;
  int64_t now_us = 5 * kSecond;
  int32_t last_pid = 100;
  bool slow_start = false;
  std::vector<StartCommand> starts;
  std::vector<int64_t> start_times_us;
  std::vector<StopCommand> stops;
  std::vector<std::string> told;
  std::vector<TellSheriffs::Tone> tones;
};

TEST(DeputyState, StartsWhenTheRunIdDiffersAndNotAgain) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.order(lidar_spec(), 1);
  ASSERT_THAT(world.starts, SizeIs(1));
  EXPECT_EQ(world.lidar().pid, 101);
  EXPECT_EQ(world.lidar().actual_runid, 1);
  world.end("lidar", 0);
  world.order(lidar_spec(), 1);
  EXPECT_THAT(world.starts, SizeIs(1)) << "what ran to its end rests";
}

TEST(DeputyState, ForceQuitAndRunIdZeroStartNothing) {
  DeputyWorld world;
  world.deputy.on_orders(orders_of({{lidar_spec(), 3, true}, {{"imu", "imu"}, 0, false}}),
                         kWallClock, 0);
  world.work();
  EXPECT_THAT(world.starts, IsEmpty());
  EXPECT_EQ(world.deputy.commands().at(1).actual_runid, 3) << "a rest run id is taken over";
}

TEST(DeputyState, StopsOnceWithTheCommandsOwnSignalAndTime) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.order(lidar_spec(), 1, true);
  world.order(lidar_spec(), 1, true);
  ASSERT_THAT(world.stops, SizeIs(1));
  EXPECT_EQ(world.stops[0].signal, 15);
  EXPECT_EQ(world.stops[0].allowed_s, 3.0);
}

// The public deputy waits for a second order, up to a second.
TEST(DeputyState, ARestartTakesOneOrder) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.order(lidar_spec(), 2);
  EXPECT_THAT(world.stops, SizeIs(1));
  EXPECT_EQ(world.lidar().actual_runid, 1);
  world.end("lidar", SIGTERM);
  ASSERT_THAT(world.starts, SizeIs(2));
  EXPECT_EQ(world.starts[1].runid, 2);
  EXPECT_EQ(world.lidar().actual_runid, 2);
}

TEST(DeputyState, AStopOvertakesARestart) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.order(lidar_spec(), 2);
  world.order(lidar_spec(), 2, true);
  world.end("lidar", SIGTERM);
  EXPECT_THAT(world.starts, SizeIs(1));
}

TEST(DeputyState, ARunIdZeroDoesNotStopWhatRuns) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.order(lidar_spec(), 0);
  EXPECT_THAT(world.stops, IsEmpty());
}

// A sheriff takes pid 0 with the wanted run id for an end, and would order it to rest.
TEST(DeputyState, UntilThePidIsKnownTheOldRunIdIsReported) {
  DeputyWorld world;
  world.slow_start = true;
  world.order(lidar_spec(), 1);
  EXPECT_EQ(world.lidar().actual_runid, 0);
  world.deputy.on_started("lidar", 7);
  EXPECT_EQ(world.lidar().actual_runid, 1);
}

TEST(DeputyState, RespawnsEverSlowerAndGivesUpVisibly) {
  CommandSpec crashing = lidar_spec();
  crashing.auto_respawn = true;
  DeputyWorld world(std::nullopt, 5);
  world.order(crashing, 1);
  for (int i = 0; i < 10; ++i) {
    world.end("lidar", 3 << 8);
    world.pass_due_times();
  }
  ASSERT_THAT(world.starts, SizeIs(5));
  EXPECT_EQ(world.start_times_us[1] - world.start_times_us[0], 10'000);
  EXPECT_EQ(world.start_times_us[4] - world.start_times_us[3], 80'000);
  EXPECT_THAT(world.told.at(0), HasSubstr("gave up: 5 starts in a row"));
  EXPECT_THAT(world.told.at(0), HasSubstr("exit 3"));
  world.order(crashing, 2);
  EXPECT_THAT(world.starts, SizeIs(6)) << "a new order begins anew";
}

TEST(DeputyState, AHealthyRunEndsARowOfCrashes) {
  CommandSpec spec = lidar_spec();
  spec.auto_respawn = true;
  DeputyWorld world(std::nullopt, 3);
  world.order(spec, 1);
  for (int i = 0; i < 20; ++i) {
    world.now_us += 11 * kSecond;
    world.end("lidar", 0);
    world.pass_due_times();
  }
  EXPECT_THAT(world.starts, SizeIs(21));
  EXPECT_EQ(world.lidar().actual_runid, 1) << "respawns keep the run id";
}

TEST(DeputyState, AStoppedCommandIsNotRespawned) {
  CommandSpec spec = lidar_spec();
  spec.auto_respawn = true;
  DeputyWorld world;
  world.order(spec, 1);
  world.order(spec, 1, true);
  world.end("lidar", SIGTERM);
  EXPECT_EQ(world.deputy.next_due_us(), std::nullopt);
}

TEST(DeputyState, AStopDuringTheRespawnDelayCounts) {
  CommandSpec spec = lidar_spec();
  spec.auto_respawn = true;
  DeputyWorld world;
  world.order(spec, 1);
  world.end("lidar", 0);
  world.order(spec, 1, true);
  EXPECT_EQ(world.deputy.next_due_us(), std::nullopt);
}

TEST(DeputyState, WithoutTheFlagOnlyWhatItsScriptsContainIsStarted) {
  DeputyWorld world(std::set<std::string>{"lidar --fast"});
  world.order(lidar_spec(), 1);
  EXPECT_THAT(world.starts, SizeIs(1));
  CommandSpec foreign = {"evil", "rm -rf /"};
  world.deputy.on_orders(orders_of({{lidar_spec(), 1, false}, {foreign, 1, false}}), kWallClock, 0);
  world.work();
  EXPECT_THAT(world.starts, SizeIs(1));
  EXPECT_THAT(world.told.at(0),
              HasSubstr("refused: none of this deputy's scripts contains: rm -rf"));
  EXPECT_EQ(world.deputy.refusals().exec, 1);
  EXPECT_EQ(world.lidar().spec.id, "evil");
  EXPECT_EQ(world.lidar().exit_code, 126 << 8) << "a sheriff shows Stopped (Error)";
  EXPECT_EQ(world.lidar().actual_runid, 1) << "and does not ask again and again";
  world.order(lidar_spec(), 1);
  EXPECT_THAT(world.deputy.commands(), SizeIs(1)) << "what was refused leaves no trace";
}

TEST(DeputyState, ARespawnOfAChangedExecIsRefusedToo) {
  CommandSpec spec = lidar_spec();
  spec.auto_respawn = true;
  DeputyWorld world(std::set<std::string>{"lidar --fast"});
  world.order(spec, 1);
  spec.exec = "something else";
  world.order(spec, 1);
  world.end("lidar", 0);
  world.pass_due_times();
  ASSERT_THAT(world.starts, SizeIs(2)) << "it respawns as it was";
  EXPECT_EQ(world.starts[1].spec.exec, "lidar --fast");
  EXPECT_EQ(world.deputy.refusals().exec, 1);
}

// Another sheriff's order for the same id, with an exec that is in no script of ours.
TEST(DeputyState, ARefusedOrderAltersNothing) {
  CommandSpec spec = lidar_spec();
  spec.auto_respawn = true;
  DeputyWorld world(std::set<std::string>{"lidar --fast", "lidar --slow"});
  world.order(spec, 1);
  CommandSpec foreign = {"lidar", "rm -rf /", "other", false, 9, 0.0};
  for (int second = 0; second < 15; ++second) {
    world.now_us += kSecond;
    world.order(foreign, 77);
    world.order(foreign, 1);
  }
  EXPECT_THAT(world.stops, IsEmpty());
  EXPECT_EQ(world.lidar().spec, spec);
  EXPECT_EQ(world.lidar().actual_runid, 1);
  EXPECT_EQ(world.deputy.refusals().exec, 30);
  ASSERT_THAT(world.told, SizeIs(2)) << "said, but not with every order";
  EXPECT_THAT(world.told[0], HasSubstr("keeps running unchanged; refused: none of this"));
  world.end("lidar", 3 << 8);
  world.order(foreign, 78);  // during the respawn delay
  world.pass_due_times();
  EXPECT_THAT(world.starts, SizeIs(2));
  EXPECT_TRUE(world.lidar().pid != 0);
  CommandSpec slow = spec;
  slow.exec = "lidar --slow";
  world.order(slow, 2);
  EXPECT_THAT(world.stops, SizeIs(1)) << "an allowed exec is still obeyed";
}

TEST(DeputyState, AStopIsObeyedWhateverExecItNames) {
  DeputyWorld world(std::set<std::string>{"lidar --fast"});
  world.order(lidar_spec(), 1);
  world.order({"lidar", "something else", "", false, 2, 1.0}, 1, true);
  ASSERT_THAT(world.stops, SizeIs(1));
  EXPECT_EQ(world.stops[0].signal, 15) << "with the running command's own signal";
  EXPECT_EQ(world.lidar().spec, lidar_spec());
}

TEST(DeputyState, WithoutTheFlagNothingEndsBecauseASheriffLeavesItOut) {
  DeputyWorld world(std::set<std::string>{"lidar --fast"});
  world.order(lidar_spec(), 1);
  world.deputy.on_orders(orders_of({}), kWallClock, 0);
  world.deputy.on_orders(orders_of({}), kWallClock, 0);
  world.work();
  EXPECT_THAT(world.stops, IsEmpty());
  EXPECT_THAT(world.told, SizeIs(1));
  EXPECT_EQ(world.deputy.refusals().left_out, 1);
}

TEST(DeputyState, WithTheFlagWhatIsLeftOutIsStoppedAndForgotten) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.deputy.on_orders(orders_of({}), kWallClock, 0);
  world.work();
  EXPECT_THAT(world.stops, SizeIs(1));
  world.end("lidar", SIGTERM);
  EXPECT_THAT(world.deputy.commands(), IsEmpty());
}

TEST(DeputyState, StaleAndForeignOrdersAreIgnored) {
  DeputyWorld world;
  Orders orders = orders_of({{lidar_spec(), 1, false}});
  orders.utime_us -= 61 * kSecond;
  world.deputy.on_orders(orders, kWallClock, 0);
  orders = orders_of({{lidar_spec(), 1, false}});
  orders.deputy_id = "other";
  world.deputy.on_orders(orders, kWallClock, 0);
  world.work();
  EXPECT_THAT(world.starts, IsEmpty());
  EXPECT_EQ(world.deputy.refusals().stale, 1);
  EXPECT_THAT(world.told.at(0), HasSubstr("61 s old"));
}

TEST(DeputyState, AdoptedCommandsKeepTheirRunId) {
  DeputyWorld world(std::set<std::string>{"lidar --fast"});
  world.deputy.adopt(lidar_spec(), 4, 77, 0);
  world.order(lidar_spec(), 4);
  EXPECT_THAT(world.starts, IsEmpty());
  EXPECT_EQ(world.lidar().pid, 77);
}

TEST(DeputyState, HostileOrdersFillNoTableAndSendNoWildSignal) {
  DeputyWorld world;
  std::vector<CommandOrder> many;
  for (int i = 0; i < 3000; ++i) many.push_back({{std::to_string(i), "x"}, 0, true});
  world.deputy.on_orders(orders_of(std::move(many)), kWallClock, 0);
  EXPECT_THAT(world.deputy.commands(), SizeIs(1000));
  DeputyWorld other;
  other.order({"a", "a", "", false, -3, std::nan("")}, 1);
  other.order({"a", "a", "", false, -3, std::nan("")}, 1, true);
  EXPECT_EQ(other.stops.at(0).signal, 2);
  EXPECT_EQ(other.stops.at(0).allowed_s, 7.0);
}

TEST(DeputyState, ShutsDownWithTimeAllowedAndTheSecondTimeAtOnce) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.deputy.shut_down();
  world.work();
  EXPECT_EQ(world.stops.at(0).allowed_s, 3.0);
  EXPECT_FALSE(world.deputy.all_ended());
  world.deputy.shut_down();
  world.work();
  EXPECT_EQ(world.stops.at(1).allowed_s, 0.0);
  world.order(lidar_spec(), 2);
  world.end("lidar", SIGKILL);
  EXPECT_THAT(world.starts, SizeIs(1));
  EXPECT_TRUE(world.deputy.all_ended());
}

TEST(DeputyState, AnOrderedStopIsNoWarning) {
  DeputyWorld world;
  const auto end_by = [&](int signal) {
    world.told.clear();
    world.order(lidar_spec(), ++world.last_pid);
    world.order(lidar_spec(), world.last_pid, true);
    world.tones.clear();
    world.end("lidar", signal);
    return world.told.at(0);
  };
  EXPECT_EQ(end_by(15), "stopped");
  EXPECT_EQ(world.tones.at(0), TellSheriffs::Tone::information);
  EXPECT_EQ(end_by(SIGKILL), "Killed: it did not stop in the time allowed");
  EXPECT_EQ(world.tones.at(0), TellSheriffs::Tone::warning);
  EXPECT_EQ(end_by(SIGSEGV), "Segmentation fault");
  EXPECT_EQ(world.tones.at(0), TellSheriffs::Tone::warning);
}

TEST(DeputyState, DeathBySignalIsSaid) {
  DeputyWorld world;
  world.order(lidar_spec(), 1);
  world.end("lidar", SIGKILL);
  EXPECT_EQ(world.told.at(0), "Killed");
  world.order(lidar_spec(), 2);
  world.order(lidar_spec(), 2, true);
  world.told.clear();
  world.deputy.on_ended("lidar", SIGKILL, 0, "it was silent");
  world.work();
  EXPECT_EQ(world.told.at(0), "killed: it was silent");
}

}  // namespace
}  // namespace marco::procman
