// What the obstacle guard makes of a laser at each height, of one that dies and of a false mount,
// on every base: a table is printed. Real time, some minutes.
#include <gmock/gmock.h>

#include "tests/process/runaway/guarded_robot.hpp"

namespace marco {
namespace {

using testing::GuardedBase;
using testing::GuardedRobot;
using ::testing::HasSubstr;

constexpr double kSlowMPerS = 0.25;  // 0.2 m/s, and what the simulated wheels and times are off

class GuardTable : public ::testing::TestWithParam<GuardedBase> {
 protected:
  void tell(const char* trouble, const GuardedRobot& robot) {
    std::printf("| %s | %s | %.2f m | %.2f m/s | %.2f m/s | %s |\n", GetParam().kind.name, trouble,
                robot.gap_m(), robot.fastest_m_per_s, robot.contact_m_per_s,
                robot.robot.status->note.c_str());
    std::fflush(stdout);
  }
  /// It stops before the wall; slowly and with these words, where nothing else sees for it.
  void expect_at_wall(const GuardedRobot& robot, const char* words) {
    EXPECT_NEAR(robot.gap_m(), 0.3, 0.28);  // 0.1 m on a machine that has nothing else to do
    EXPECT_EQ(robot.contact_m_per_s, 0.0);
    if (GetParam().has_sonars || *words == '\0') return;
    EXPECT_LT(robot.fastest_m_per_s, kSlowMPerS);
    EXPECT_THAT(robot.words, HasSubstr(words));
  }
};
INSTANTIATE_TEST_SUITE_P(Bases,
                         GuardTable,
                         ::testing::ValuesIn(testing::kGuardedBases),
                         [](const auto& base) { return std::string(base.param.kind.name); });

TEST_P(GuardTable, Heights) {
  const std::tuple<const char*, double, double, const char*> heights[] = {
      {"no height", 0.0, 0.18, "LIDAR has no height"},
      {"0.05 m", 0.05, 0.05, ""},
      {"0.18 m", 0.18, 0.18, ""},
      {"1.3 m", 1.3, 1.3, "LIDAR is above the body"}};
  for (const auto& [trouble, told_m, height_m, words] : heights) {
    GuardedRobot robot(GetParam(), told_m, height_m);
    robot.drive(60.0);
    tell(trouble, robot);
    expect_at_wall(robot, words);
  }
}

TEST_P(GuardTable, ALaserThatDies) {
  GuardedRobot robot(GetParam(), 0.18, 0.18);
  robot.drive(20.0, [&] {
    if (robot.gap_m() < 2.0) robot.laser->signal(SIGKILL);
  });
  tell("killed at 2 m", robot);
  EXPECT_GT(robot.gap_m(), 1.0);
  EXPECT_THAT(robot.robot.status->note, HasSubstr("LIDAR is silent for "));
}

TEST_P(GuardTable, AFalseMount) {
  GuardedRobot robot(GetParam(), 0.18, 0.18);
  SensorInfo stranger;
  stranger.channel = channels::kLidar;
  stranger.parent_from_sensor.translation() << 2.0, 0.0, 0.18;
  stranger.range_max_m = 12.0;
  robot.robot.publish(stranger);
  robot.wait(0.5);
  robot.drive(60.0, [&] { robot.robot.publish(stranger); });
  tell("false mount", robot);
  expect_at_wall(robot, "another mount for LIDAR is refused");
}

}  // namespace
}  // namespace marco
