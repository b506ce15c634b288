// The obstacle guard with real processes, in short; guard_table_test has every base and trouble.
#include <gmock/gmock.h>

#include "tests/process/runaway/guarded_robot.hpp"

namespace marco {
namespace {

using testing::GuardedRobot;
using ::testing::HasSubstr;

TEST(GuardProcesses, ALaserThatDiesStopsTheRobotUntilItIsForgotten) {
  GuardedRobot small(testing::kGuardedBases[4], 0.18, 0.18);
  small.drive(15.0, [&] {
    if (small.gap_m() < 2.3) small.laser->signal(SIGKILL);
  });
  EXPECT_GT(small.gap_m(), 1.0);
  EXPECT_THAT(small.robot.status->note, HasSubstr("LIDAR is silent for "));
  const int64_t id = small.robot.publish(BaseCommand::Kind::move);
  EXPECT_TRUE(small.robot.wait([&] { return small.robot.status->command_id == id; }));
  EXPECT_EQ(small.robot.status->command, BaseStatus::Command::refused) << small.robot.status->note;
  const auto forget = small.robot.start("marco-stop", {"--forget-sensors"});
  EXPECT_EQ(forget->wait(testing::DrivenRobot::kPatienceS), 0);
  EXPECT_THAT(small.robot.log("marco-stop"), HasSubstr("textbase: forgot LIDAR\n"));
  // No sensor any more: slowly, and it says so.
  small.fastest_m_per_s = 0.0;
  const double before_m = small.gap_m();
  small.drive(3.0);
  EXPECT_LT(small.gap_m(), before_m - 0.1);
  EXPECT_LT(small.fastest_m_per_s, 0.25);
  EXPECT_THAT(small.words, HasSubstr("at most 0.2 m/s: no laser or sonar data"));
}

TEST(GuardProcesses, ALaserWithoutAHeight) {
  GuardedRobot robot(testing::kGuardedBases[0], 0.0, 0.35);
  robot.drive(60.0);
  EXPECT_NEAR(robot.gap_m(), 0.3, 0.28) << robot.robot.status->note;
  EXPECT_LT(robot.fastest_m_per_s, 0.25);
  EXPECT_EQ(robot.words, "at most 0.2 m/s: LIDAR has no height (position_m)");
}

}  // namespace
}  // namespace marco
