#include "slam/doctor/odometry_windows.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::slam {
namespace {

Utime second(int i) { return Utime::from_us(1'000'000 * static_cast<int64_t>(i)); }

// A winding way of 0.1 m a second, and an odometry that is 3 % long, turns 1 degree a metre too far
// and is off by a few millimetres a step.
class OdometryWindows : public ::testing::Test {
 protected:
  OdometryWindows() {
    std::mt19937 random(12);
    std::normal_distribution<double> noise(0.0, 1.0);
    Pose2 truth, odom;
    for (int i = 0; i < 800; ++i) {
      path_.push_back({second(i), truth});
      odometry_.push_back({second(i), odom});
      const Pose2 step{0.1, 0.0, 0.02 * std::sin(0.05 * i)};
      truth = truth * step;
      odom = odom * Pose2{1.03 * step.x_m + 0.003 * noise(random), 0.002 * noise(random),
                          step.theta_rad + deg_to_rad(0.1) + 0.003 * noise(random)};
    }
  }
  // From scan `from` on the whole map is moved.
  void tear(std::size_t from, const Pose2& moved) {
    const Pose2 at = path_[from].world_from_robot;
    for (std::size_t i = from; i < path_.size(); ++i) {
      path_[i].world_from_robot = at * moved * between(at, path_[i].world_from_robot);
    }
  }
  Trajectory path_, odometry_;
};

TEST_F(OdometryWindows, LearnsWhatTheOdometryUsuallyDoes) {
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  EXPECT_TRUE(agreement.present);
  EXPECT_GT(agreement.way_correlation, 0.99);
  EXPECT_TRUE(agreement.breaks.empty());
}

TEST_F(OdometryWindows, FindsWhereScansSlidAlongAHall) {
  tear(400, {0.7, 0.0, 0.0});
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  ASSERT_EQ(agreement.breaks.size(), 1U);
  EXPECT_LE(agreement.breaks[0].from, second(400));
  EXPECT_GE(agreement.breaks[0].to, second(400));
  EXPECT_NEAR(agreement.breaks[0].map.x_m - agreement.breaks[0].odometry.x_m, 0.7, 0.1);
}

TEST_F(OdometryWindows, FindsATurnThatTheRobotDidNotMake) {
  tear(300, {0.0, 0.0, deg_to_rad(25)});
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  ASSERT_EQ(agreement.breaks.size(), 1U);
  EXPECT_LE(agreement.breaks[0].from, second(300));
  EXPECT_GE(agreement.breaks[0].to, second(300));
}

TEST_F(OdometryWindows, AnOdometryThatStandsSaysNothing) {
  for (StampedPose2& pose : odometry_) pose.world_from_robot = {3.0, 1.0, 0.4};
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  EXPECT_FALSE(agreement.present);
  EXPECT_TRUE(agreement.breaks.empty());
}

// A laser that looks aside, and the log does not say so.
TEST_F(OdometryWindows, GoesWithAMapThatIsTurnedAgainstIt) {
  for (StampedPose2& pose : odometry_) {
    pose.world_from_robot = pose.world_from_robot * Pose2{0.0, 0.0, deg_to_rad(80)};
  }
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  EXPECT_GT(agreement.way_correlation, 0.99);
  EXPECT_TRUE(agreement.breaks.empty());
}

TEST_F(OdometryWindows, GivesTheWayBetweenTwoStamps) {
  const auto way = way_by_odometry(odometry_, second(10), second(20));
  ASSERT_TRUE(way.has_value());
  EXPECT_NEAR(way->x_m, 1.03, 0.05);
  EXPECT_FALSE(way_by_odometry(odometry_, second(10), second(9000)).has_value());
}

TEST_F(OdometryWindows, TellsALostSign) {
  for (StampedPose2& pose : odometry_) {
    pose.world_from_robot.x_m *= -1.0;
    pose.world_from_robot.y_m *= -1.0;
  }
  const OdometryAgreement agreement = compare_with_odometry(path_, odometry_);
  EXPECT_LT(agreement.way_correlation, -0.9);
  EXPECT_GT(agreement.turn_correlation, 0.9);
}

// The map's path is the laser's, half a metre ahead of the wheels: it moves where the robot only
// turns.
TEST(OdometryWindowsOnTheSpot, ALaserAheadOfTheWheelsIsNoBreak) {
  Trajectory path, odometry;
  Pose2 robot;
  for (int i = 0; i < 600; ++i) {
    const bool turns = i % 100 > 80;
    path.push_back({second(i), robot * Pose2{0.45, 0.0, 0.0}});
    odometry.push_back({second(i), robot});
    robot = robot * (turns ? Pose2{0.0, 0.0, deg_to_rad(8)} : Pose2{0.1, 0.0, 0.0});
  }
  EXPECT_TRUE(compare_with_odometry(path, odometry).breaks.empty());
}

}  // namespace
}  // namespace marco::slam
