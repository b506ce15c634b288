#include "lcm_tools/procman/sheriff_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "lcm_tools/procman/command_table.hpp"
#include "lcm_tools/tests/unit/procman/sheriff_world.hpp"

namespace marco::procman {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

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

// "Stopped (OK)" after a stop is what the stop itself does: its signal, and KILL when time is over.
TEST(SheriffState, AnotherSignalAfterAStopIsAnError) {
  const auto status_after = [](int raw_status) {
    SheriffWorld world;
    world.sheriff.start("lidar");
    world.exchange();
    DeputyInfo info{world.now_us, "base", {}, world.deputy.commands()};
    world.sheriff.stop("lidar");
    for (CommandStatus& command : info.commands) {
      if (command.spec.id != "lidar") continue;
      command.pid = 0;
      command.exit_code = raw_status;
    }
    world.sheriff.on_info(info, world.now_us, world.now_us);
    return world.status("lidar");
  };
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    EXPECT_EQ(status_after(signal), Status::stopped_ok) << signal;
  }
  for (const int signal : {SIGINT, SIGTERM}) {  // caught
    EXPECT_EQ(status_after((128 + signal) << 8), Status::stopped_ok);
  }
  EXPECT_EQ(status_after((128 + SIGSEGV) << 8), Status::stopped_error);
  EXPECT_EQ(status_after(SIGSEGV), Status::stopped_error);
  EXPECT_EQ(status_after(SIGABRT), Status::stopped_error);
  EXPECT_EQ(status_after(1 << 8), Status::stopped_error);
}

TEST(SheriffState, OnlyItsOwnDeputysReportCounts) {
  SheriffWorld world;
  CommandStatus running{world.sheriff.commands().at("lidar").spec};
  running.pid = 5;
  running.actual_runid = 9;
  world.sheriff.on_info({world.now_us, "elsewhere", {}, {running}}, world.now_us, world.now_us);
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  EXPECT_EQ(world.sheriff.commands().at("lidar").deputy, "base");
  EXPECT_EQ(world.sheriff.commands().at("lidar").desired_runid, 0);
  EXPECT_THAT(world.sheriff.running(), IsEmpty());
  world.sheriff.start("lidar");
  world.exchange();
  EXPECT_THAT(world.sheriff.running(), ElementsAre("lidar"));
  world.sheriff.on_info({world.now_us, "elsewhere", {}, {}}, world.now_us, world.now_us);
  EXPECT_EQ(world.status("lidar"), Status::running) << "nor what another does not list";
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

/// A guest beside the sheriff of a world: it knows what both said last.
struct Guest {
  explicit Guest(SheriffWorld& of) : world(of) { learn(); }
  void learn() {
    world.now_us += kSecondUs;
    for (const Orders& orders : world.sheriff.take_due_orders(world.now_us, world.now_us)) {
      state.on_orders(orders);
    }
    state.on_info({world.now_us, "base", {}, world.deputy.commands()}, world.now_us, world.now_us);
  }
  void order(const std::string& id, const std::string& action) {
    const Orders orders = state.single_order(id, action, world.now_us, world.now_us);
    world.deputy.on_orders(orders, world.now_us, world.now_us);
    world.sheriff.on_orders(orders);
    world.exchange();
    world.pass(kSecondUs);
  }

  SheriffWorld& world;
  SheriffState state{"guest:test", true};
};

TEST(SheriffState, AGuestsOrderIsAdoptedAndKept) {
  SheriffWorld world;
  for (PlacedCommand placed : all_commands(world.config)) {
    placed.command.auto_respawn = true;
    world.sheriff.put(placed);
  }
  world.sheriff.start("lidar");
  world.exchange();
  Guest guest(world);
  guest.order("lidar", "restart");
  EXPECT_EQ(world.status("lidar"), Status::running);
  EXPECT_EQ(world.last_pid, 12) << "two starts, no more";
  guest.order("lidar", "stop");
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  // The sheriff repeats it, for a deputy that was started anew as well.
  world.deputy = DeputyState({"base", std::nullopt});
  world.info();
  world.pass(kSecondUs);
  EXPECT_EQ(world.status("lidar"), Status::stopped_ok);
  EXPECT_EQ(world.last_pid, 12);
}

// A guest repeats what it has heard of the other commands, which may be over.
TEST(SheriffState, WhatAGuestKnewBeforeIsNotAdopted) {
  SheriffWorld world;
  world.sheriff.start("logger");
  world.sheriff.start("lidar");
  world.exchange();
  Guest guest(world);
  world.sheriff.stop("logger");
  world.sheriff.restart("lidar");
  world.sheriff.on_orders(guest.state.single_order("left", "start", world.now_us, world.now_us));
  EXPECT_TRUE(world.sheriff.commands().at("logger").force_quit);
  EXPECT_EQ(world.sheriff.commands().at("lidar").desired_runid, 2);
  EXPECT_EQ(world.sheriff.commands().at("left").desired_runid, 1);
  world.sheriff.on_orders({0, "elsewhere", "guest:test", {{{"left", "x"}, 9, false}}});
  world.sheriff.on_orders({0, "base", "a sheriff", {{{"left", "x"}, 9, false}}});
  EXPECT_EQ(world.sheriff.commands().at("left").desired_runid, 1);
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

TEST(SheriffState, AClockBehindIsSaidAndNotEverySecond) {
  SheriffWorld world(false);
  const auto hear = [&](int64_t age_s, int64_t at_s) {
    return world.sheriff.on_info({world.now_us - age_s * kSecondUs, "base", {}, {}}, world.now_us,
                                 at_s * kSecondUs);
  };
  EXPECT_THAT(hear(40, 1), ElementsAre("deputy base is ignored: its clock is 40 s behind ours. "
                                       "Synchronize both clocks (chrony, ntp)"));
  EXPECT_THAT(hear(40, 2), IsEmpty());
  EXPECT_THAT(hear(40, 62), SizeIs(1));
  EXPECT_THAT(hear(29, 63), ElementsAre("deputy base is there"));
}

TEST(SheriffState, TargetsMeanGroupsWithTheirSubgroups) {
  const SheriffWorld world;
  EXPECT_THAT(world.sheriff.commands_of({TargetKind::group, "drivers"}),
              ElementsAre("left", "lidar"));
  EXPECT_THAT(world.sheriff.commands_of({TargetKind::command, "left"}), ElementsAre("left"));
  EXPECT_THAT(world.sheriff.commands_of({}), SizeIs(3));
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
  other.on_info(info, now_us, 0);
  EXPECT_THAT(other.deputies(), IsEmpty());
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
