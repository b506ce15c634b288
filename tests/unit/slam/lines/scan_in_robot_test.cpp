#include "slam/line_slam/lines/scan_in_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace marco::slam {
namespace {

// 181 beams of a half circle; the one at `bearing_deg` has 1 m and a hundredth of that more.
LaserScan half_circle(const std::vector<int>& order) {
  LaserScan scan;
  for (const int degree : order) {
    scan.ranges_m.push_back(degree == 30 ? 0.0F : 1.0F + 0.01F * static_cast<float>(degree));
    scan.bearings_rad.push_back(static_cast<float>(deg_to_rad(degree - 90.0)));
  }
  return scan;
}

ScanInRobot in_robot(const LaserScan& scan, const Pose3& robot_from_sensor, double yaw_rate = 0.0) {
  SensorInfo info;
  info.parent_from_sensor = robot_from_sensor;
  info.scan_duration_s = 0.1;
  const DeskewedScan deskewed =
      deskew_and_project(scan, info, robot_from_sensor, {0.0, 0.0, yaw_rate});
  return to_robot_frame(scan, info, robot_from_sensor, deskewed, 0.02);
}

std::vector<int> ascending() {
  std::vector<int> order(181);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

std::vector<int> interlaced() {
  std::vector<int> order;
  for (int i = 0; i <= 180; i += 2) order.push_back(i);
  for (int i = 1; i <= 180; i += 2) order.push_back(i);
  return order;
}

TEST(ScanInRobot, HoldsTheBeamsInOrderOfBearingHoweverTheyWereMeasured) {
  std::vector<int> descending = ascending();
  std::reverse(descending.begin(), descending.end());
  for (const std::vector<int>& order : {ascending(), descending, interlaced()}) {
    const ScanInRobot scan = in_robot(half_circle(order), make_pose3({0.2, 0.0, 0.3}));
    ASSERT_EQ(scan.beams.size(), 181U);
    EXPECT_NEAR(scan.first_bearing_rad, deg_to_rad(-90), 1e-6);
    EXPECT_NEAR(scan.bearing_step_rad, deg_to_rad(1), 1e-6);
    EXPECT_EQ(scan.range_sigma_m, 0.02);
    EXPECT_FALSE(scan.beams[30].returned);
    for (int i = 0; i <= 180; ++i) {
      const Beam& beam = scan.beams[static_cast<std::size_t>(i)];
      if (i == 30) continue;
      EXPECT_TRUE(beam.returned) << i;
      EXPECT_NEAR(beam.range_m, 1.0 + 0.01 * i, 1e-6);
      const double bearing_rad = deg_to_rad(i - 90.0);
      EXPECT_NEAR(beam.hit_m.x(), 0.2 + beam.range_m * std::cos(bearing_rad), 1e-5);
      EXPECT_NEAR(beam.hit_m.y(), beam.range_m * std::sin(bearing_rad), 1e-5);
    }
  }
}

TEST(ScanInRobot, OfALaserMountedUpsideDownTheOrderIsThatSeenFromAbove) {
  const ScanInRobot scan =
      in_robot(half_circle(ascending()), make_pose3({0, 0, 0.3}, std::numbers::pi));
  EXPECT_NEAR(scan.first_bearing_rad, deg_to_rad(-90), 1e-6);
  EXPECT_NEAR(scan.beams[0].range_m, 2.8, 1e-6);
  EXPECT_NEAR(scan.beams[0].hit_m.y(), -2.8, 1e-5);
}

TEST(ScanInRobot, HitsAreThoseOfTheDeskewedScan) {
  const ScanInRobot still = in_robot(half_circle(ascending()), Pose3::Identity());
  const ScanInRobot turning = in_robot(half_circle(ascending()), Pose3::Identity(), 1.0);
  // The last beam was measured 0.1 rad later.
  EXPECT_NEAR((turning.beams[0].hit_m - still.beams[0].hit_m).norm(), 0.0, 1e-9);
  EXPECT_NEAR(turning.beams[180].hit_m.x(), -2.8 * std::sin(0.1), 1e-5);
}

}  // namespace
}  // namespace marco::slam
