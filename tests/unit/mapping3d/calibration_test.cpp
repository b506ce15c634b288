#include "mapping3d/calibration.hpp"

#include <gtest/gtest.h>

#include <array>
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

constexpr double kRowS = 0.013, kDegPerS = 75.0;

enum class Ways { both, up };

/// Sweeps from the middle of the room at four pans, by a pan-tilt that is `truth` off what it says;
/// up and down by turns, or all of them up.
std::vector<Scene> pantilt_sweeps(const PanTiltCorrection& truth,
                                  double sigma_m,
                                  unsigned seed = 5,
                                  Ways ways = Ways::both) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_m);
  const PanTiltGeometry said = as_said();
  const SensorInfo base = truth.base(said.base), sensor = truth.sensor(said.sensor);
  std::vector<Scene> scenes;
  for (const double pan_deg : {0.0, 90.0, 180.0, 270.0}) {
    const bool up = ways == Ways::up || std::fmod(pan_deg, 180.0) == 0.0;
    const double deg_per_s = up ? kDegPerS : -kDegPerS;
    Scene scene;
    for (int i = 0; i < 66; ++i) {
      SceneRow row;
      row.world_from_robot = {-0.4, 0.3, 0.2};
      row.first_bearing_rad = deg_to_rad(-90.0);
      row.bearing_step_rad = deg_to_rad(1.0);
      row.duration_s = kRowS;
      row.pan_first_rad = row.pan_last_rad = deg_to_rad(pan_deg);
      row.tilt_first_rad = deg_to_rad(up ? -20.0 + i : 45.0 - i);
      row.tilt_last_rad = row.tilt_first_rad + deg_to_rad(deg_per_s * kRowS);
      row.robot_from_sensor_first =
          robot_from_pantilt_sensor(said.base, said.sensor, row.pan_first_rad, row.tilt_first_rad);
      row.robot_from_sensor_last =
          robot_from_pantilt_sensor(said.base, said.sensor, row.pan_last_rad, row.tilt_last_rad);
      for (int beam = 0; beam < 181; ++beam) {
        const double late_deg = deg_per_s * (truth.late_s + kRowS * beam / 180.0);
        const Pose3 laser = lift(row.world_from_robot) *
                            robot_from_pantilt_sensor(base, sensor, row.pan_first_rad,
                                                      row.tilt_first_rad + deg_to_rad(late_deg));
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

std::array<double, 8> values(const PanTiltCorrection& c) {
  return {c.axis_x_m, c.axis_y_m,  c.lever_x_m, c.lever_z_m,
          c.roll_deg, c.pitch_deg, c.yaw_deg,   c.late_s};
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
  EXPECT_NEAR(found.late_s, truth.late_s, 0.002);
}

TEST(Calibrate, FindsErrorsOfTwoDegreesAndTwoCentimetres) {
  const PanTiltCorrection truth{0.02, -0.02, 0.02, -0.02, 2.0, -2.0, 2.0, 0.02};
  const CalibrationResult result = calibrate(pantilt_sweeps(truth, 0.0), as_said());
  expect_found(truth, result);
  EXPECT_LT(result.after_m, 0.1 * result.before_m);
}

TEST(Calibrate, FindsThemThroughACentimetreOfNoise) {
  const PanTiltCorrection truth{-0.02, 0.02, 0.02, 0.02, -2.0, 2.0, -2.0, -0.02};
  const CalibrationResult result = calibrate(pantilt_sweeps(truth, 0.010), as_said());
  const auto found = values(result.correction), sigma = values(result.sigma);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], values(truth)[i], 3.0 * sigma[i]) << i;
  }
  EXPECT_NEAR(found[1], truth.axis_y_m, 0.003);
  EXPECT_NEAR(found[4], truth.roll_deg, 0.1);
  EXPECT_NEAR(found[7], truth.late_s, 0.002);
}

// A correction that may be chance is none.
TEST(Calibrate, AGoodGeometryStays) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    EXPECT_EQ(values(calibrate(pantilt_sweeps({}, 0.005, seed), as_said()).correction),
              values(PanTiltCorrection{}))
        << seed;
  }
}

// One in twenty of normal errors lies beyond two standard deviations.
TEST(Calibrate, StandardDeviationsAreThoseOfTheErrors) {
  const PanTiltCorrection truth{0.02, -0.02, 0.02, -0.02, 1.0, -1.0, 1.0, 0.02};
  const auto true_values = values(truth);
  int beyond = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const CalibrationResult result = calibrate(pantilt_sweeps(truth, 0.005, seed), as_said());
    const auto found = values(result.found), sigma = values(result.sigma);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double sigmas = std::abs(found[i] - true_values[i]) / sigma[i];
      beyond += sigmas > 2.0 ? 1 : 0;
      EXPECT_LT(sigmas, 4.0) << seed << ": " << i;
    }
    EXPECT_LT(result.sigma.late_s, 0.002);
  }
  EXPECT_LE(beyond, 4);
}

// Then a late angle is almost a wrong zero.
TEST(Calibrate, SweepsThatGoOneWayTellLessSurelyHowLateAnglesAre) {
  const PanTiltCorrection truth{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02};
  const CalibrationResult both = calibrate(pantilt_sweeps(truth, 0.005, 1), as_said());
  const CalibrationResult up = calibrate(pantilt_sweeps(truth, 0.005, 1, Ways::up), as_said());
  EXPECT_GT(up.sigma.late_s, 2.0 * both.sigma.late_s);
  EXPECT_LT(std::abs(up.found.late_s - truth.late_s), 3.0 * up.sigma.late_s);
}

TEST(Calibrate, OneSweepTellsNothing) {
  std::vector<Scene> scenes = pantilt_sweeps({}, 0.0);
  scenes.resize(1);
  EXPECT_EQ(calibrate(scenes, as_said()).status, CalibrationResult::Status::nothing_seen_twice);
  EXPECT_EQ(calibrate({}, as_said()).status, CalibrationResult::Status::nothing_seen_twice);
}

}  // namespace
}  // namespace marco::mapping3d
