#include "teleop/first_drive.hpp"

#include <gmock/gmock.h>
#include <pty.h>
#include <unistd.h>

#include "teleop/terminal.hpp"

namespace marco::teleop {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

Utime at(double seconds) { return Utime::from_seconds(1000.0 + seconds); }

/// How long the motion lasts when the key repeats from then on, each `every_s`, until it is let go.
double held_s(double first_repeat_s, double every_s, double released_s, char other = ' ') {
  HeldMotion held(at(0.0));
  double repeat_s = first_repeat_s;
  for (double now_s = 0.0;; now_s += 0.01) {
    if (now_s >= repeat_s && repeat_s < released_s) {
      held.on_key(other, at(now_s));
      repeat_s += every_s;
    }
    if (!held.goes(at(now_s)) && now_s > 2.0) return 2.0;
    if (!held.goes(at(now_s))) return now_s;
  }
}

TEST(HeldMotion, EndsWithTheKeyAndInAnyCaseBeforeASecond) {
  EXPECT_NEAR(held_s(0.5, 0.03, 9.0), 0.9, 0.02);
  EXPECT_NEAR(held_s(0.25, 0.03, 0.4), 0.64, 0.03) << "released: soon after the last repetition";
  EXPECT_NEAR(held_s(9.0, 0.03, 9.0), 0.6, 0.02) << "pressed once";
  EXPECT_NEAR(held_s(0.66, 0.03, 9.0), 0.6, 0.02) << "a late repetition starts nothing again";
  EXPECT_NEAR(held_s(0.1, 9.0, 9.0, 'x'), 0.1, 0.02) << "another key";
}

/// Counters ten times a second of a robot that moves from `begin_s` to `end_s`, along x.
std::vector<OdometrySample> track(double begin_s, double end_s, double start_x_m) {
  std::vector<OdometrySample> samples;
  for (int i = 0; i < 30; ++i) {
    OdometrySample sample;
    sample.utime = at(0.1 * i);
    const double driven_s = std::clamp(0.1 * i, begin_s, end_s) - begin_s;
    sample.odom_from_robot = Pose2{5.0, start_x_m, deg_to_rad(90.0)} * Pose2{0.1 * driven_s, 0, 0};
    samples.push_back(sample);
  }
  return samples;
}

TEST(SeenMotion, IsTimedFromTheOrdersAndMeasuredFromWhereTheRobotWas) {
  const SeenMotion seen = seen_motion(track(0.55, 1.35, 3.0), at(0.3), at(1.2));
  EXPECT_NEAR(seen.start_from_end.x_m, 0.08, 1e-9);
  EXPECT_NEAR(seen.start_from_end.y_m, 0.0, 1e-9);
  EXPECT_NEAR(seen.begins_s.value_or(-1.0), 0.3, 1e-6);  // the first sample that shows it
  EXPECT_NEAR(seen.stands_s, 0.1, 1e-6);
  // Moved before the order, and never by it.
  const SeenMotion still = seen_motion(track(0.0, 0.3, 3.0), at(0.4), at(1.2));
  EXPECT_FALSE(still.begins_s.has_value());
  EXPECT_EQ(still.stands_s, 0.0);
  EXPECT_FALSE(seen_motion({}, at(0.4), at(1.2)).begins_s.has_value());
}

/// A scan of one beam at 20 degrees to the laser's left, and returns that are none.
SynchronizedScan scan(double range_m, double laser_yaw_deg, double roll_deg = 0.0) {
  SynchronizedScan scan;
  scan.scan.utime = at(0.0);
  scan.scan.ranges_m = {0.0F, static_cast<float>(range_m), 0.04F, 30.0F};
  scan.scan.first_bearing_rad = deg_to_rad(10.0);
  scan.scan.bearing_step_rad = deg_to_rad(10.0);
  scan.info.range_min_m = 0.05;
  scan.info.range_max_m = 12.0;
  scan.robot_from_sensor =
      make_pose3({0.1, 0.0, 0.2}, deg_to_rad(roll_deg), 0.0, deg_to_rad(laser_yaw_deg));
  return scan;
}

TEST(NearestReturn, IsSeenFromTheRobot) {
  const auto bearing_deg = [](const SynchronizedScan& one) {
    return rad_to_deg(nearest_return({{"LIDAR", one}}, at(0.5))->bearing_rad);
  };
  EXPECT_NEAR(bearing_deg(scan(0.4, 0.0)), 20.0, 1e-6);
  EXPECT_NEAR(bearing_deg(scan(0.4, 90.0)), 110.0, 1e-6);
  EXPECT_NEAR(bearing_deg(scan(0.4, 0.0, 180.0)), -20.0, 1e-6) << "it hangs upside down";
  const auto nearest =
      nearest_return({{"LIDAR_A", scan(0.4, 0.0)}, {"LIDAR_B", scan(0.3, 90.0)}}, at(0.5));
  EXPECT_NEAR(nearest->range_m, 0.3, 1e-6);
  EXPECT_NEAR(rad_to_deg(nearest->bearing_rad), 110.0, 1e-6);
  EXPECT_FALSE(nearest_return({{"LIDAR", scan(0.4, 0.0)}}, at(1.5)).has_value()) << "an old scan";
  EXPECT_FALSE(nearest_return({{"LIDAR", scan(0.0, 0.0)}}, at(0.5)).has_value()) << "no return";
}

Check check(const char* name, const char* answer, const char* fault) {
  Check made(name);
  made.answer = answer;
  made.fault = fault;
  return made;
}

TEST(Check, FindsWhatTheMessagesContradict) {
  const auto fault_of_motion = [](const Pose2& way, double ahead, double left, double stands_s) {
    Check motion("motion");
    motion.judge_motion({way, 0.1, stands_s}, ahead, left);
    return motion.fault;
  };
  EXPECT_EQ(fault_of_motion({0.05, 0.0, 0.01}, 1.0, 0.0, 0.2), "");
  EXPECT_EQ(fault_of_motion({-0.05, 0.0, 0.01}, -1.0, 0.0, 0.2), "");
  EXPECT_EQ(fault_of_motion({0.0, 0.0, -0.3}, 0.0, -1.0, 0.2), "");
  const std::string other = "odometry shows another motion";
  EXPECT_EQ(fault_of_motion({-0.05, 0.0, 0.0}, 1.0, 0.0, 0.2), other) << "it counts backwards";
  EXPECT_EQ(fault_of_motion({0.03, 0.0, 0.3}, 1.0, 0.0, 0.2), other) << "one wheel stands";
  EXPECT_EQ(fault_of_motion({0.0, 0.0, -0.3}, 0.0, 1.0, 0.2), other) << "wheels exchanged";
  EXPECT_EQ(fault_of_motion({0.06, 0.0, 0.0}, 0.0, 1.0, 0.2), other) << "one wheel reversed";
  EXPECT_EQ(fault_of_motion({}, 1.0, 0.0, 0.0), other);
  EXPECT_THAT(fault_of_motion({0.05, 0.0, 0.0}, 1.0, 0.0, 1.2), HasSubstr("did not stop"));
  const auto fault_of_hand = [](std::optional<NearestReturn> nearest) {
    Check hand("hand");
    hand.judge_hand(nearest, 45.0);
    return hand.fault;
  };
  EXPECT_EQ(fault_of_hand(NearestReturn{0.3, deg_to_rad(60.0)}), "");
  EXPECT_THAT(fault_of_hand(NearestReturn{0.3, deg_to_rad(-45.0)}), HasSubstr("elsewhere"));
  EXPECT_THAT(fault_of_hand(std::nullopt), HasSubstr("no laser"));
  Check push("push");
  push.judge_push({1.05, 0.0, 0.0});
  EXPECT_EQ(push.fault, "");
  push.judge_push({0.85, 0.0, 0.0});
  EXPECT_NE(push.fault, "");
}

TEST(DriveReport, IsGoodWhereNeitherPersonNorMessagesContradict) {
  DriveReport report{"0.1", "", "kobuki", {check("blocks", "yes", "")}, ""};
  report.checks.push_back(check("bumper", "skipped", ""));
  EXPECT_TRUE(report.is_good());
  for (const Check& wrong : {check("ahead", "no", ""), check("ahead", "yes", "backwards"),
                             check("ahead", "skipped", "backwards")}) {
    DriveReport bad = report;
    bad.checks.push_back(wrong);
    EXPECT_FALSE(bad.is_good());
    EXPECT_THAT(bad.to_text(), HasSubstr("ahead          WRONG"));
  }
  report.ended_early = "stopped by a signal";
  EXPECT_FALSE(report.is_good());
}

// What a base's note or a person may hold.
TEST(DriveReport, StaysTomlWhateverTextsHold) {
  DriveReport report{"0.1", "my \"robot\"\\", "a\nb\x1b[2J", {}, ""};
  report.checks.push_back(check("ahead", "yes", "no\n[[checks]]"));
  report.checks.back().figures = {{"moved_m", 0.051}};
  const std::string toml = report.to_toml();
  EXPECT_THAT(toml,
              StartsWith("# first drive of a\\x0ab\\x1b[2J, Marco 0.1\n#  ahead          WRONG"));
  EXPECT_THAT(toml, HasSubstr("\nrobot = \"my \\\"robot\\\"\\\\\"\n"));
  EXPECT_THAT(toml, HasSubstr("\nbase = \"a\\\\x0ab\\\\x1b[2J\"\n"));
  EXPECT_THAT(toml, HasSubstr("\nfault = \"no\\\\x0a[[checks]]\"\n"));
  EXPECT_THAT(toml, HasSubstr("\nmoved_m = 0.0510\n"));
}

// Of a session without a controlling terminal, where no SIGHUP comes.
TEST(Keyboard, ReportsThatItsTerminalIsGone) {
  int person = -1, program = -1;
  ASSERT_EQ(openpty(&person, &program, nullptr, nullptr, nullptr), 0);
  const int before = dup(STDIN_FILENO);
  dup2(program, STDIN_FILENO);
  {
    Keyboard keyboard;
    EXPECT_EQ(keyboard.key(), std::nullopt);
    EXPECT_EQ(write(person, "y", 1), 1);
    EXPECT_EQ(keyboard.key(), 'y');
    close(person);
    EXPECT_THROW(keyboard.key(), std::runtime_error);
  }
  dup2(before, STDIN_FILENO);
  close(before);
  close(program);
}

}  // namespace
}  // namespace marco::teleop
