// The gravest of what stopping_times_test.cpp measures, on every change: the driver of a base that
// knows no deadline is killed, a gamepad is killed, and somebody says stop.
#include <gmock/gmock.h>

#include "tests/process/runaway/driven_robot.hpp"

namespace marco {
namespace {

using testing::DrivenRobot;
using ::testing::HasSubstr;

// Five times what an idle machine shows; the wheels used to turn for as long as one looked.
constexpr double kSoonS = 5.0;

TEST(Runaway, TheRobotStopsWhateverDies) {
  DrivenRobot robot(DrivenRobot::kHcs12);
  robot.start_base();
  robot.start_gamepad_and_teleop();
  EXPECT_LT(robot.stopping_s([&] { robot.gamepad->signal(SIGKILL); }), kSoonS);
  robot.start_gamepad_and_teleop();
  EXPECT_LT(robot.stopping_s([&] { robot.base->signal(SIGKILL); }), kSoonS);
}

TEST(Runaway, MarcoStopStopsAndSaysWhoDid) {
  DrivenRobot robot(DrivenRobot::kPioneer);
  const auto lonely = robot.start("marco-stop", {});
  EXPECT_EQ(lonely->wait(DrivenRobot::kPatienceS), 1);
  EXPECT_THAT(robot.log("marco-stop"), HasSubstr("no base answers"));
  robot.start_base();
  robot.start_gamepad_and_teleop();
  std::unique_ptr<testing::Program> stop;
  robot.stopping_s([&] { stop = robot.start("marco-stop", {"--reason", "a test"}); });
  EXPECT_EQ(stop->wait(DrivenRobot::kPatienceS), 0) << robot.log("marco-stop");
  EXPECT_THAT(robot.log("marco-stop"), HasSubstr("p2os: stopped"));
  // The stick is still held.
  EXPECT_TRUE(robot.wait([&] { return robot.status->command == BaseStatus::Command::refused; }));
  EXPECT_THAT(robot.status->note, HasSubstr("emergency stop by marco stop: a test"));
  const auto release = robot.start("marco-stop", {"--release"});
  EXPECT_TRUE(robot.wait([&] { return robot.turns(); }));
  EXPECT_EQ(release->wait(DrivenRobot::kPatienceS), 0) << robot.log("marco-stop");
}

}  // namespace
}  // namespace marco
