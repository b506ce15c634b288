#include "common/input/deskew.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

TEST(Velocity2, FollowsTheArcOfManySmallSteps) {
  const Velocity2 velocity{1.0, -0.3, 0.7};
  Pose2 stepped;
  constexpr int kSteps = 200000;
  const double dt = 2.0 / kSteps;
  for (int i = 0; i < kSteps; ++i) stepped = stepped * Pose2{1.0 * dt, -0.3 * dt, 0.7 * dt};
  // Each small step is wrong by half its turn: 1e-5 m in all.
  EXPECT_THAT(velocity.after(2.0), IsNear(stepped, 2e-5, 1e-9));
  EXPECT_THAT((Velocity2{1.0, 0.5, 0.0}.after(2.0)), IsNear(Pose2{2.0, 1.0, 0.0}, 1e-12, 0.0));
}

TEST(Velocity2, IsThatOfTheMotionItLeadsTo) {
  for (const double yaw_rad_per_s : {0.0, 0.7, -2.0}) {
    const Velocity2 velocity{1.0, -0.3, yaw_rad_per_s};
    const Velocity2 found = velocity_of(velocity.after(0.02), 0.02);
    // The chord is shorter than its arc by a part of turn squared / 24.
    EXPECT_NEAR(found.ahead_m_per_s, 1.0, 1e-4);
    EXPECT_NEAR(found.left_m_per_s, -0.3, 1e-4);
    EXPECT_NEAR(found.yaw_rad_per_s, yaw_rad_per_s, 1e-9);
  }
}

// Equal steps are rotated, listed bearings are not.
TEST(PrepareScan, BeamsLieWhereTheirBearingsAre) {
  LaserScan even, listed;
  even.ranges_m.assign(300, 2.0F);
  listed.ranges_m = even.ranges_m;
  even.first_bearing_rad = -1.0;
  even.bearing_step_rad = 0.01;
  for (int i = 0; i < 300; ++i) {
    listed.bearings_rad.push_back(static_cast<float>(0.001 * i + 1e-5 * i * i));
  }
  even.utime = Utime::from_seconds(7.0);
  const DeskewedScan of_even = deskew_and_project(even, {}, Pose3::Identity(), {});
  const DeskewedScan of_listed =
      deskew_and_project(listed, {}, make_pose3({0, 0, 0}, 0, 0, 0.4), {});
  EXPECT_EQ(of_even.utime, even.utime);
  EXPECT_NEAR(of_listed.sensor_heading_rad, 0.4, 1e-12);
  ASSERT_EQ(of_even.hits_in_robot.cols(), 300);
  ASSERT_EQ(of_listed.beam_of_hit.size(), 300U);
  for (int i = 0; i < 300; ++i) {
    const double bearing_rad = -1.0 + 0.01 * i, other_rad = 0.4 + 0.001 * i + 1e-5 * i * i;
    const Eigen::Vector2d ray(std::cos(bearing_rad), std::sin(bearing_rad));
    const Eigen::Vector2d other(std::cos(other_rad), std::sin(other_rad));
    EXPECT_LT((of_even.hits_in_robot.col(i) - 2.0 * ray).norm(), 1e-9) << i;
    EXPECT_LT((of_listed.hits_in_robot.col(i) - 2.0 * other).norm(), 1e-6) << i;
    EXPECT_EQ(of_listed.beam_of_hit[static_cast<std::size_t>(i)], i);
  }
}

TEST(PrepareScan, KeepsReturnsWithinLimitsOnly) {
  LaserScan scan;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  scan.ranges_m = {1.0F, 0.0F, nan, inf, -1.0F, 81.83F, 0.05F, 2.0F};
  scan.first_bearing_rad = 0.0;
  scan.bearing_step_rad = 0.1;
  SensorInfo info;
  info.range_min_m = 0.1;
  info.range_max_m = 80.0;
  const DeskewedScan prepared = deskew_and_project(scan, info, make_pose3({0.2, 0.1, 0.5}), {});
  EXPECT_EQ(prepared.beams, 8);
  EXPECT_EQ(prepared.no_return, 6);
  ASSERT_EQ(prepared.hits_in_robot.cols(), 2);
  EXPECT_NEAR((prepared.hits_in_robot.col(0) - Eigen::Vector2d(1.2, 0.1)).norm(), 0.0, 1e-7);
  EXPECT_NEAR((prepared.hits_in_robot.col(1) -
               Eigen::Vector2d(0.2 + 2.0 * std::cos(0.7), 0.1 + 2.0 * std::sin(0.7)))
                  .norm(),
              0.0, 1e-7);
}

TEST(PrepareScan, MovesEachBeamToTheFirstBeamsTime) {
  // The robot drives ahead at 1 m/s while three beams, 0.1 s apart, look ahead at a wall 3 m away.
  LaserScan scan;
  scan.ranges_m = {3.0F, 2.9F, 2.8F};
  SensorInfo info;
  info.scan_duration_s = 0.2;
  const DeskewedScan prepared = deskew_and_project(scan, info, Pose3::Identity(), {1.0, 0.0, 0.0});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(prepared.hits_in_robot(0, i), 3.0, 1e-6);
  scan.time_offsets_s = {0.0F, 0.2F, 0.4F};
  const DeskewedScan slower = deskew_and_project(scan, info, Pose3::Identity(), {1.0, 0.0, 0.0});
  EXPECT_NEAR(slower.hits_in_robot(0, 2), 3.2, 1e-6);
}

TEST(DeskewedAgain, EqualsAScanDeskewedSoAtOnce) {
  LaserScan scan;
  scan.ranges_m = {3.0F, 2.0F, 0.0F, 1.0F};
  scan.bearing_step_rad = 1.5;
  scan.time_offsets_s = {0.0F, 0.05F, 0.1F, 0.15F};
  const Velocity2 predicted{0.3, 0.1, 1.0}, found{0.5, 0.0, -2.0};
  const Pose3 laser = make_pose3({0.2, 0.1, 0.3}, 0.0, 0.0, 0.4);
  const DeskewedScan wanted = deskew_and_project(scan, {}, laser, found);
  const DeskewedScan before = deskew_and_project(scan, {}, laser, predicted);
  const DeskewedScan again = deskewed_again(before, before.time_of_hit_s, found);
  EXPECT_LT((again.hits_in_robot - wanted.hits_in_robot).norm(), 1e-6);
  EXPECT_GT((again.hits_in_robot - before.hits_in_robot).norm(), 0.3);
  EXPECT_EQ(again.velocity.yaw_rad_per_s, -2.0);
  scan.time_offsets_s = {0.15F, 0.1F, 0.05F, 0.0F};
  const DeskewedScan reversed = deskewed_again(before, {0.15F, 0.1F, 0.0F}, found);
  EXPECT_LT(
      (reversed.hits_in_robot - deskew_and_project(scan, {}, laser, found).hits_in_robot).norm(),
      1e-6);
}

TEST(FirstFromMiddle, IsTheWayToTheMeanOfTheHitsTimes) {
  LaserScan scan;
  scan.ranges_m = {3.0F, 0.0F, 2.0F};
  scan.time_offsets_s = {0.0F, 0.05F, 0.2F};
  const Velocity2 velocity{1.0, 0.0, 0.5};
  const DeskewedScan deskewed = deskew_and_project(scan, {}, Pose3::Identity(), velocity);
  EXPECT_THAT(first_from_middle(deskewed), IsNear(velocity.after(0.1), 1e-7, 1e-7));
  EXPECT_THAT(first_from_middle(DeskewedScan{}), IsNear(Pose2{}, 0.0, 0.0));
}

TEST(PrepareScan, AnEmptyScanStaysEmpty) {
  const DeskewedScan prepared = deskew_and_project({}, {}, Pose3::Identity(), {});
  EXPECT_EQ(prepared.hits_in_robot.cols(), 0);
}

}  // namespace
}  // namespace marco
