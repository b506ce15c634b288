#include "common/input/pantilt_track.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "common/input/pantilt_correction.hpp"

namespace marco {
namespace {

Utime moment(double seconds) { return Utime::from_seconds(seconds); }

PanTiltState state_at(double seconds, double pan_rad, double tilt_rad) {
  PanTiltState state;
  state.utime = moment(seconds);
  state.pan_rad = pan_rad;
  state.tilt_rad = tilt_rad;
  return state;
}

TEST(PanTiltTrack, InterpolatesBetweenStatesAndAcrossTheBack) {
  PanTiltTrack track;
  track.add(state_at(1.0, 3.0, 0.1));
  track.add(state_at(1.4, -3.0, 0.3));
  const auto angles = track.at(moment(1.1));
  ASSERT_TRUE(angles);
  EXPECT_NEAR(angles->pan_rad, 3.0 + 0.25 * (2.0 * std::numbers::pi - 6.0), 1e-9);
  EXPECT_NEAR(angles->tilt_rad, 0.15, 1e-9);
  EXPECT_EQ(track.at(moment(1.4))->pan_rad, -3.0);
  EXPECT_EQ(track.at(moment(1.0))->pan_rad, 3.0);
  EXPECT_FALSE(track.at(moment(0.99)));
}

TEST(PanTiltTrack, ContinuesAsItMovedForAsLongAsItsReach) {
  PanTiltTrack track;
  EXPECT_FALSE(track.at(moment(1.0)));
  track.add(state_at(1.0, 0.0, 0.5));
  EXPECT_EQ(track.at(moment(1.05))->tilt_rad, 0.5) << "of one state nothing is known of its motion";
  track.add(state_at(1.2, 0.4, 0.1));
  EXPECT_NEAR(track.at(moment(1.25))->pan_rad, 0.5, 1e-9);
  EXPECT_NEAR(track.at(moment(1.25))->tilt_rad, 0.0, 1e-9);
  EXPECT_FALSE(track.at(moment(1.31)));
}

TEST(PanTiltTrack, AcrossAGapOnlyOneThatStoodIsKnown) {
  PanTiltTrack moved, panned, crept, stood;
  for (PanTiltTrack* track : {&moved, &panned, &crept, &stood}) track->add(state_at(1.0, 0.2, 0.1));
  moved.add(state_at(3.0, 0.2, 0.3));
  panned.add(state_at(3.0, 0.4, 0.1));
  crept.add(state_at(3.0, 0.203, 0.1));
  stood.add(state_at(3.0, 0.201, 0.101));
  EXPECT_FALSE(moved.at(moment(2.0)));
  EXPECT_FALSE(panned.at(moment(2.0)));
  EXPECT_FALSE(crept.at(moment(2.0)));
  ASSERT_TRUE(stood.at(moment(2.0)));
  EXPECT_NEAR(stood.at(moment(2.0))->tilt_rad, 0.1005, 1e-9);
  EXPECT_EQ(moved.at(moment(3.05))->tilt_rad, 0.3) << "its motion before says nothing";
}

TEST(PanTiltTrack, AStampThatStepsBackDropsWhatItContradicts) {
  PanTiltTrack track;
  EXPECT_TRUE(track.add(state_at(1.0, 0.0, 0.0)));
  EXPECT_TRUE(track.add(state_at(2.0, 1.0, 0.0)));
  EXPECT_FALSE(track.add(state_at(2.0, 0.6, 0.0)));
  EXPECT_NEAR(track.at(moment(1.5))->pan_rad, 0.3, 1e-9);
  EXPECT_FALSE(track.add(state_at(1.5, 0.4, 0.0)));
  EXPECT_TRUE(track.reaches(moment(1.5)));
  EXPECT_FALSE(track.reaches(moment(1.6)));
  EXPECT_NEAR(track.at(moment(1.25))->pan_rad, 0.2, 1e-9);
}

TEST(PanTiltTrack, ForgetsWhatIsFiftySecondsOld) {
  PanTiltTrack track;
  for (int i = 0; i <= 5100; ++i) track.add(state_at(0.01 * i, 0.0, 0.0));
  EXPECT_FALSE(track.at(moment(0.5)));
  EXPECT_TRUE(track.at(moment(1.5)));
}

TEST(PanTiltCorrection, MovesTheAxisAndTheLaserOnItsPlate) {
  PanTiltCorrection correction;
  correction.axis_x_m = 0.02;
  correction.axis_y_m = -0.01;
  correction.lever_x_m = 0.03;
  correction.lever_z_m = 0.05;
  correction.pitch_deg = 10.0;
  SensorInfo said;
  said.channel = "LIDAR";
  said.tilt_axis_m = {0.1, 0.0, 0.2};
  said.parent_from_sensor = make_pose3({0.01, 0.02, 0.03});
  const SensorInfo base = correction.base(said);
  EXPECT_EQ(base.channel, "LIDAR");
  EXPECT_NEAR((base.tilt_axis_m - Eigen::Vector3d(0.12, -0.01, 0.2)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(base.parent_from_sensor.isApprox(said.parent_from_sensor));
  const SensorInfo sensor = correction.sensor(said);
  EXPECT_EQ(sensor.channel, "LIDAR");
  // It looks down, where it is: turned about itself.
  const Eigen::Vector3d ahead = sensor.parent_from_sensor * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d wanted(0.04 + std::cos(deg_to_rad(10.0)), 0.02,
                               0.08 - std::sin(deg_to_rad(10.0)));
  EXPECT_NEAR((ahead - wanted).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace marco
