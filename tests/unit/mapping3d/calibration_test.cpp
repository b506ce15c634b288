#include "mapping3d/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

PanTiltGeometry as_said() {
  PanTiltGeometry geometry;
  geometry.base.parent_from_sensor = make_pose3({0.05, 0.0, 0.6});
  geometry.base.tilt_axis_m = {0.02, 0.0, 0.1};
  geometry.sensor.parent_from_sensor = make_pose3({0.045, 0.0, 0.008});
  return geometry;
}

/// Sweeps from the middle of the room at four pans, by a pan-tilt that is `truth` off what it says.
std::vector<Scene> sweeps(const PanTiltCorrection& truth, double sigma_m) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, sigma_m);
  const PanTiltGeometry said = as_said();
  const SensorInfo base = truth.base(said.base), sensor = truth.sensor(said.sensor);
  std::vector<Scene> scenes;
  for (const double pan_deg : {0.0, 90.0, 180.0, 270.0}) {
    Scene scene;
    for (int i = 0; i < 66; ++i) {
      SceneRow row;
      row.world_from_robot = {-0.4, 0.3, 0.2};
      row.first_bearing_rad = deg_to_rad(-90.0);
      row.bearing_step_rad = deg_to_rad(1.0);
      row.pan_first_rad = row.pan_last_rad = deg_to_rad(pan_deg);
      row.tilt_first_rad = row.tilt_last_rad = deg_to_rad(-20.0 + i);
      row.robot_from_sensor_first = row.robot_from_sensor_last =
          robot_from_pantilt_sensor(said.base, said.sensor, row.pan_first_rad, row.tilt_first_rad);
      const Pose3 laser =
          lift(row.world_from_robot) *
          robot_from_pantilt_sensor(base, sensor, row.pan_first_rad, row.tilt_first_rad);
      for (int beam = 0; beam < 181; ++beam) {
        const double bearing_rad = row.first_bearing_rad + beam * row.bearing_step_rad;
        const Eigen::Vector3d direction =
            laser.linear() * Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0);
        row.ranges_m.push_back(static_cast<float>(
            AnalyticRoom::range_m(laser.translation(), direction) + noise(random)));
      }
      scene.rows.push_back(row);
    }
    scenes.push_back(scene);
  }
  return scenes;
}

void expect_found(const PanTiltCorrection& truth, const CalibrationResult& result) {
  EXPECT_EQ(result.status, CalibrationResult::Status::converged);
  const PanTiltCorrection& found = result.correction;
  EXPECT_NEAR(found.axis_x_m, truth.axis_x_m, 0.003);
  EXPECT_NEAR(found.axis_y_m, truth.axis_y_m, 0.003);
  EXPECT_NEAR(found.lever_x_m, truth.lever_x_m, 0.003);
  EXPECT_NEAR(found.lever_z_m, truth.lever_z_m, 0.003);
  EXPECT_NEAR(found.roll_deg, truth.roll_deg, 0.1);
  EXPECT_NEAR(found.pitch_deg, truth.pitch_deg, 0.1);
  EXPECT_NEAR(found.yaw_deg, truth.yaw_deg, 0.1);
}

TEST(Calibrate, FindsErrorsOfTwoDegreesAndTwoCentimetres) {
  const PanTiltCorrection truth{0.02, -0.02, 0.02, -0.02, 2.0, -2.0, 2.0};
  const CalibrationResult result = calibrate(sweeps(truth, 0.0), as_said());
  expect_found(truth, result);
  EXPECT_LT(result.after_m, 0.1 * result.before_m);
}

TEST(Calibrate, FindsThemThroughACentimetreOfNoise) {
  const PanTiltCorrection truth{-0.02, 0.02, 0.02, 0.02, -2.0, 2.0, -2.0};
  const CalibrationResult result = calibrate(sweeps(truth, 0.010), as_said());
  expect_found(truth, result);
}

TEST(Calibrate, AGoodGeometryStays) { expect_found({}, calibrate(sweeps({}, 0.005), as_said())); }

TEST(Calibrate, OneSweepTellsNothing) {
  std::vector<Scene> scenes = sweeps({}, 0.0);
  scenes.resize(1);
  EXPECT_EQ(calibrate(scenes, as_said()).status, CalibrationResult::Status::nothing_seen_twice);
  EXPECT_EQ(calibrate({}, as_said()).status, CalibrationResult::Status::nothing_seen_twice);
}

}  // namespace
}  // namespace marco::mapping3d
