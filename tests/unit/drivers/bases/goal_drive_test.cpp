#include "teleop/goal_drive.hpp"

#include <gtest/gtest.h>

namespace marco::teleop {
namespace {

using Command = BaseStatus::Command;
using GoalNext = GoalDrive::Next;

BaseStatus status(int64_t id, Command command) {
  BaseStatus said;
  said.command_id = id;
  said.command = command;
  return said;
}

TEST(GoalDrive, TheOrderIsGivenAgainUntilTheRobotStandsNearEnough) {
  GoalDrive drive({2.0, 1.0});
  drive.on_ordered(7);
  EXPECT_EQ(drive.on_status(status(3, Command::done), 2.0), GoalNext::wait);  // of the order before
  EXPECT_FALSE(drive.is_taken());
  EXPECT_EQ(drive.on_status(status(7, Command::running), 1.0), GoalNext::wait);
  EXPECT_TRUE(drive.is_taken());
  EXPECT_EQ(drive.on_status(status(7, Command::done), 0.25), GoalNext::again);
  drive.on_ordered(8);
  EXPECT_EQ(drive.on_status(status(7, Command::done), 0.25), GoalNext::wait);
  EXPECT_EQ(drive.on_status(status(8, Command::done), 0.04), GoalNext::there);
}

TEST(GoalDrive, ItEndsWhereAnotherLegBringsItNoNearer) {
  GoalDrive drive({2.0, 1.0});
  drive.on_ordered(1);
  EXPECT_EQ(drive.on_status(status(1, Command::done), 0.3), GoalNext::again);
  drive.on_ordered(2);
  EXPECT_EQ(drive.on_status(status(2, Command::done), 0.25), GoalNext::there);
  GoalDrive slow({2.0, 1.0});
  double distance_m = 1.0;
  int legs = 0;
  GoalNext next = GoalNext::again;
  while (next == GoalNext::again) {
    slow.on_ordered(++legs);
    next = slow.on_status(status(legs, Command::done), distance_m *= 0.65);
    ASSERT_LE(legs, 5);
  }
  EXPECT_EQ(next, GoalNext::there);
}

TEST(GoalDrive, ItEndsWithTheBasesWordAndWithOrdersOfOthers) {
  for (const Command fate : {Command::shortened, Command::refused, Command::aborted}) {
    GoalDrive drive({2.0, 1.0});
    drive.on_ordered(1);
    EXPECT_EQ(drive.on_status(status(1, fate), 1.0), GoalNext::ended);
  }
  GoalDrive drive({2.0, 1.0});
  drive.on_ordered(1);
  EXPECT_EQ(drive.on_status(status(1, Command::running), 1.0), GoalNext::wait);
  EXPECT_EQ(drive.on_status(status(9, Command::running), 1.0), GoalNext::ended);
}

}  // namespace
}  // namespace marco::teleop
