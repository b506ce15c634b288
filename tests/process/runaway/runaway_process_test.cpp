// The gravest of what stopping_times_test.cpp measures, on every change: the driver of a base that
// knows no deadline is killed, a gamepad is killed, and somebody says stop.
#include <gmock/gmock.h>

#include "drivers/base/stop_latch.hpp"
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

// The base has no watchdog of its own.
TEST(Runaway, ADriverThatHangsIsStoppedAndItsEmergencyStopOutlivesIt) {
  DrivenRobot robot(DrivenRobot::kCreate);
  robot.start_base();
  robot.start_gamepad_and_teleop();
  EXPECT_LT(robot.stopping_s([&] { robot.base->signal(SIGSTOP); }), kSoonS);
  EXPECT_TRUE(robot.wait([&] { return robot.says("its driver hangs"); }));
  robot.gamepad.reset();
  robot.teleop.reset();
  robot.wait([] { return false; }, 0.6);  // its last orders are old then
  robot.base->signal(SIGCONT);
  EXPECT_TRUE(robot.wait([&] { return robot.says("the driver hung for "); }));
  EXPECT_FALSE(robot.wait([&] { return robot.turns(); }, 1.0));

  robot.start_gamepad_and_teleop();
  robot.stopping_s([&] { robot.base->signal(SIGSTOP); });
  const auto stop = robot.start("marco-stop", {"--reason", "a test"});
  EXPECT_EQ(stop->wait(DrivenRobot::kPatienceS), 0) << robot.log("marco-stop");
  EXPECT_TRUE(robot.wait(
      [&] { return robot.says("emergency stop by marco stop: a test; its driver hangs"); }));
  robot.base->signal(SIGKILL);
  robot.start_base();  // and the stick is held
  EXPECT_TRUE(robot.says("emergency stop by marco stop: a test"));
  EXPECT_FALSE(robot.wait([&] { return robot.turns(); }, 1.0));
  robot.publish(false, "test");
  EXPECT_TRUE(robot.wait([&] { return robot.turns(); }));
  robot.base->signal(SIGKILL);
  robot.start_base();
  EXPECT_TRUE(robot.wait([&] { return robot.turns(); }));

  // A guardian keeps it late, on a slow disk: the next driver, which runs already, reads it then.
  const drivers::StopLatch latch(robot.status->base, "");
  latch.save(EmergencyStop{drivers::wall_now(), true, "me", ""});
  kill(robot.guardian(robot.base->pid()), SIGKILL);  // the line is opened again
  EXPECT_TRUE(robot.wait([&] { return robot.says("emergency stop by me") && robot.rests(); }));
  EXPECT_TRUE(robot.wait([&] { return robot.status->link == BaseStatus::Link::up; }));
  robot.publish(false, "test");
  EXPECT_TRUE(robot.wait([&] { return !latch.load(); }));
}

// The keeper's kill of a silent driver, and the deputy's of one whose keeper is gone, spare the
// guardian, which stops what the driver drove.
TEST(Runaway, ProcmanRestartsADriverThatHangsAndSparesItsGuardian) {
  DrivenRobot robot(DrivenRobot::kCreate);
  std::ofstream(robot.file("create.procman"))
      << "cmd \"base\" { exec = \"" << robot.driver_line()
      << "\"; deputy = \"localhost\"; auto_respawn = \"true\"; }\n"
      << "script \"go\" { start cmd \"base\"; }\n";
  const auto sheriff = robot.start("marco-procman-sheriff",
                                   {"-n", "-l", "--output", robot.file("create.procman"), "go"});
  for (const bool by_keeper : {true, false}) {
    const auto up = [&] { return robot.status && robot.status->link == BaseStatus::Link::up; };
    ASSERT_TRUE(robot.wait(up)) << robot.log("marco-procman-sheriff");
    robot.start_gamepad_and_teleop();
    const pid_t driver = robot.driver();
    const pid_t keeper = testing::parent_of(driver);
    ASSERT_GT(keeper, 1);
    const double took_s = robot.stopping_s([&] {
      by_keeper ? kill(driver, SIGSTOP) : kill(keeper, SIGKILL);
      robot.gamepad.reset();  // the next driver would obey them
      robot.teleop.reset();
    });
    EXPECT_LT(took_s, kSoonS);
    EXPECT_TRUE(robot.wait([&] { return robot.driver() != driver && robot.driver() != 0; }));
    robot.status.reset();
  }
  EXPECT_THAT(robot.log("marco-procman-sheriff"), HasSubstr("its heartbeat was silent for 3 s"));
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait(DrivenRobot::kPatienceS), 0);
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
