// Scans of lasers on the pan-tilt, and which lasers lie level.
#include <cmath>

#include "tests/unit/input/sensor_synchronizer_fixture.hpp"

namespace marco {
namespace {

using PanTiltScansTest = SensorSynchronizerTest;

TEST_F(PanTiltScansTest, AScanOnThePanTiltHasTheAnglesOfBothBeamsAndIsLevelOnlyWhenBothAre) {
  announce(channels::kPanTiltState);
  announce(channels::kLidar, SensorInfo::Mount::pantilt, 0.1);
  pantilt(0.0, 0.2, 0.0);
  scan(0.0);
  pantilt(0.05, 0.2, 0.0);
  EXPECT_TRUE(take().empty());
  pantilt(0.1, 0.2, 0.0);
  auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_TRUE(scans[0].level && scans[0].angles_known);
  EXPECT_NEAR(scans[0].first_angles.pan_rad, 0.2, 1e-9);
  EXPECT_NEAR(scans[0].robot_from_sensor.linear()(1, 0), std::sin(0.2), 1e-9);
  scan(0.15);
  pantilt(0.2, 0.2, 0.0);
  pantilt(0.3, 0.2, 0.1);
  scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_FALSE(scans[0].level);
  EXPECT_NEAR(scans[0].last_angles.tilt_rad, 0.05, 1e-9);
  scan(0.3);
  pantilt(0.5, 0.4, 0.0);  // panned meanwhile, level again
  scan(0.5);
  scans = take();
  ASSERT_GE(scans.size(), 1U);
  EXPECT_FALSE(scans[0].level);
}

// Levelness is the whole mounting's: mount, pan and tilt.
TEST_F(PanTiltScansTest, AVerticalLaserIsNotLevelAndLetsANoddingOneBeMatched) {
  const auto mount = [this](const char* channel, SensorInfo::Mount on, double pitch_deg) {
    SensorInfo info;
    info.channel = channel;
    info.mount = on;
    info.parent_from_sensor = make_pose3({0, 0, 0.5}, 0.0, deg_to_rad(pitch_deg));
    input_.add(info);
  };
  double seconds = 0.0;
  const auto levels = [&](double tilt_deg) {
    seconds += 0.2;
    pantilt(seconds, 0.3, deg_to_rad(tilt_deg));
    scan(seconds);
    scan(seconds + 0.01, "LIDAR_OTHER");
    pantilt(seconds + 0.1, 0.3, deg_to_rad(tilt_deg));
    std::vector<bool> found;
    for (const SynchronizedScan& synchronized : take()) found.push_back(synchronized.level);
    return found;
  };
  announce(channels::kPanTiltState);
  mount("LIDAR_OTHER", SensorInfo::Mount::robot, -90.0);
  mount(channels::kLidar, SensorInfo::Mount::pantilt, 0.0);
  EXPECT_EQ(levels(0.0), (std::vector<bool>{true, false}));
  EXPECT_EQ(levels(5.0), (std::vector<bool>{false, false}));
  mount(channels::kLidar, SensorInfo::Mount::pantilt, 5.0);  // looks down; tilt > 0 looks up
  EXPECT_EQ(levels(0.0), (std::vector<bool>{false, false}));
  EXPECT_EQ(levels(5.0), (std::vector<bool>{true, false}));
  mount("LIDAR_OTHER", SensorInfo::Mount::robot, 5.0);
  EXPECT_EQ(levels(5.0), (std::vector<bool>{false, true})) << "a fixed one is matched alone";
}

// A recorder starts the pan-tilt's driver after the laser's.
TEST_F(PanTiltScansTest, TheFirstScansOnThePanTiltWaitForItsFirstAngles) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  announce(channels::kPanTiltState);
  scan(0.0);
  scan(0.1);
  EXPECT_TRUE(take().empty());
  pantilt(0.15, 0.0, 0.3);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_FALSE(scans[0].level);
  EXPECT_FALSE(scans[0].angles_known);
}

TEST_F(PanTiltScansTest, OnASilentPanTiltTheLaserIsWhereItIsAtAnglesOfZero) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  SensorInfo base;
  base.channel = channels::kPanTiltState;
  base.parent_from_sensor.translation().x() = 0.5;
  input_.add(base);
  for (const double seconds : {0.0, 0.3, 0.6}) scan(seconds);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 3U);  // and none that comes waits any more
  EXPECT_TRUE(scans[0].level);
  EXPECT_NEAR(scans[0].robot_from_sensor.translation().x(), 0.5, 1e-12);
}

TEST_F(PanTiltScansTest, AFallenSilentPanTiltIsWaitedForNoLongerThanThePatience) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt, 0.3);
  announce(channels::kPanTiltState);
  pantilt(0.0, 0.1, 0.0);
  pantilt(0.1, 0.2, 0.0);
  scan(0.1);
  EXPECT_TRUE(take().empty());
  scan(0.35);  // its last beam is more than the patience later, and those before it go first
  EXPECT_TRUE(take().empty());
  scan(0.7);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_FALSE(scans[0].angles_known) << "those of its last beam";
  EXPECT_NEAR(scans[0].first_angles.pan_rad, 0.2, 1e-9);
  EXPECT_NEAR(scans[0].last_angles.pan_rad, 0.2, 1e-9);
  EXPECT_NEAR(scans[2].first_angles.pan_rad, 0.2, 1e-9) << "it stands where it was";
}

TEST_F(PanTiltScansTest, WithAFixedLaserOneOnASilentPanTiltIsNotMatched) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  announce(channels::kPanTiltState);
  announce("LIDAR_FRONT");
  scan(0.0, "LIDAR_FRONT");
  for (const double seconds : {0.05, 0.35, 0.65}) scan(seconds);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_TRUE(scans[0].level);
  EXPECT_FALSE(scans[1].level);
}

TEST_F(PanTiltScansTest, WithoutThePanTiltsOwnPlaceItsAnglesTellNothing) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  pantilt(0.0, 0.2, 0.3);
  scan(0.05);
  pantilt(0.1, 0.2, 0.3);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_FALSE(scans[0].angles_known);
  EXPECT_TRUE(scans[0].robot_from_sensor.isApprox(Pose3::Identity()));
}

TEST_F(PanTiltScansTest, LateStampsOfThePanTiltAreCorrected) {
  SynchronizerOptions options;
  options.pantilt_late_s = 0.1;
  input_ = SensorSynchronizer(options, {channels::kPanTiltState, &channels::lidar_of}, {});
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  announce(channels::kPanTiltState);
  for (int i = 0; i <= 10; ++i) pantilt(0.1 * i, 0.1 * i, 0.0);  // 1 rad/s
  scan(0.5);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_NEAR(scans[0].first_angles.pan_rad, 0.6, 1e-6);
}

TEST_F(PanTiltScansTest, AStampOfThePanTiltThatStepsBackIsCounted) {
  for (const double seconds : {0.0, 0.1, 0.05}) pantilt(seconds, 0.0, 0.0);
  EXPECT_EQ(drops_, (std::map<std::string, int>{{"pan-tilt stamp steps back", 1}}));
}

}  // namespace
}  // namespace marco
