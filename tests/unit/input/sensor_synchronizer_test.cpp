#include <gmock/gmock.h>

#include <random>

#include "tests/support/matchers.hpp"
#include "tests/unit/input/sensor_synchronizer_fixture.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

TEST_F(SensorSynchronizerTest, AScanWaitsForOdometryAtItsLastBeam) {
  announce(channels::kLidar, SensorInfo::Mount::robot, 0.1);
  odometry(0.0, {});
  scan(0.1);
  odometry(0.15, {0.15, 0, 0});
  EXPECT_TRUE(take().empty());
  odometry(0.3, {0.3, 0, 0});
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_THAT(*scans[0].motion.odom_from_robot, IsNear(Pose2{0.1, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(*scans[0].odometry_step, IsNear(Pose2{0.1, 0, 0}, 1e-9, 1e-9));
}

TEST_F(SensorSynchronizerTest, SilentOdometryIsWaitedForNoLongerThanThePatience) {
  odometry(0.0, {});
  scan(0.2);
  scan(0.6);
  EXPECT_TRUE(take().empty() || drops_.empty());
  scan(0.8);
  EXPECT_EQ(input_.state().waiting.size(), 0U);
}

TEST_F(SensorSynchronizerTest, WithoutSensorInfoAScanIsDroppedAndCounted) {
  scan(0.1, "LIDAR_REAR");
  EXPECT_TRUE(take().empty());
  EXPECT_EQ(drops_["no SENSOR_INFO for LIDAR_REAR yet"], 1);
}

// 0.5 m/s; every fourth to sixth scan is stamped like the third, and its line holds the odometry
// that the logger looked up by that stamp.
TEST_F(SensorSynchronizerTest, OdometryThatWasLookedUpByAStalledStampIsLookedUpByTheRepairedOne) {
  std::vector<Pose2> truth;
  for (int i = 0; i < 90; ++i) {
    const bool stalled = i % 6 > 2;
    const int stamped = stalled ? i - i % 6 + 2 : i;
    truth.push_back({0.1 * i, 0, 0});
    const double stamp_s = 0.2 * stamped + 0.001 * (i - stamped);
    odometry(stamp_s, {0.5 * stamp_s, 0, 0});
    scan(stamp_s);
  }
  input_.complete_all();
  const auto scans = take();
  ASSERT_EQ(scans.size(), 90U);
  EXPECT_TRUE(input_.state().odometry.is_looked_up());
  for (std::size_t i = 31; i < 84; ++i) {
    const Pose2 step =
        between(*scans[i - 1].motion.odom_from_robot, *scans[i].motion.odom_from_robot);
    EXPECT_THAT(step, IsNear(Pose2{0.1, 0, 0}, 0.035, 1e-6)) << i;
    EXPECT_NEAR(scans[i].motion.scan_period_s, 0.2, 0.01) << i;
    EXPECT_NEAR(scans[i].motion.utime.seconds(), 0.2 * static_cast<double>(i), 0.07) << i;
    EXPECT_EQ(scans[i].motion.off_beat > 0.5, i % 6 > 2 || i % 6 == 0) << i;
  }
}

// It is known when the stall is over: it is waited for by two seconds more.
TEST_F(SensorSynchronizerTest, OdometryThatIsLookedUpIsWaitedForOverAStall) {
  for (int i = 0; i < 87; ++i) {
    const int stamped = i % 6 > 2 ? i - i % 6 + 2 : i;
    const double stamp_s = 0.2 * stamped + 0.001 * (i - stamped);
    odometry(stamp_s, {0.5 * stamp_s, 0, 0});
    scan(stamp_s);
  }
  ASSERT_TRUE(input_.state().odometry.is_looked_up());
  take();
  for (int i = 87; i < 99; ++i) scan(0.2 * i);  // 2.4 s without odometry
  EXPECT_TRUE(take().empty());
  for (int i = 99; i < 103; ++i) scan(0.2 * i);
  EXPECT_FALSE(take().empty());
}

TEST_F(SensorSynchronizerTest, OdometryThatCameWithAScanIsUsedWhateverItsStamp) {
  std::vector<Pose2> truth;
  Pose2 now;
  for (int i = 0; i < 60; ++i) {
    now = now * Pose2{0.05 + 0.05 * (i / 7 % 2), 0, 0.1 * (i / 5 % 2)};  // changes as it likes
    truth.push_back(now);
    const double stamp_s = 0.1 * (i - i % 3) + 0.001 * (i % 3);
    // Beside it: before or after.
    if (i % 2 == 0) odometry(stamp_s, now);
    scan(stamp_s);
    if (i % 2 == 1) odometry(stamp_s, now);
  }
  input_.complete_all();
  const auto scans = take();
  ASSERT_EQ(scans.size(), 60U);
  EXPECT_FALSE(input_.state().odometry.is_looked_up());
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_THAT(*scans[i].motion.odom_from_robot, IsNear(truth[i], 1e-9, 1e-9)) << i;
    EXPECT_EQ(scans[i].scan.utime.us, Utime::from_seconds(0.1 * static_cast<double>(i - i % 3) +
                                                          0.001 * static_cast<double>(i % 3))
                                          .us);
  }
}

// Stamps of a logger that jitters by more than the laser's period, and four of five scans missing.
TEST_F(SensorSynchronizerTest, OdometryThatCameWithOneOfFiveScansIsUsedWhateverItsStamp) {
  std::mt19937 random(2);
  std::bernoulli_distribution missing(0.8);
  std::exponential_distribution<double> late(1.0 / 0.1);
  std::vector<Pose2> truth;
  Pose2 now;
  double written_s = 0.0;
  for (int i = 0; i < 3000; ++i) {
    now = now * Pose2{0.1, 0, i / 40 % 2 == 0 ? 0.0 : 0.1};
    written_s = std::max(written_s + 0.001, 0.2 * i + late(random));  // in the order of measurement
    if (missing(random)) continue;
    truth.push_back(now);
    odometry(written_s, now);
    scan(written_s);
  }
  input_.complete_all();
  const auto scans = take();
  ASSERT_EQ(scans.size(), truth.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ASSERT_THAT(*scans[i].motion.odom_from_robot, IsNear(truth[i], 1e-9, 1e-9)) << i;
  }
}

TEST_F(SensorSynchronizerTest, OdometryThatRestartedIsNotComparedWithThatBefore) {
  odometry(0.0, {5.0, 0, 0});
  odometry(0.1, {5.1, 0, 0});
  scan(0.12);  // still waits
  odometry(0.2, {0.0, 0, 0});
  odometry(0.3, {0.1, 0, 0});
  scan(0.25);
  scan(0.3);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_THAT(*scans[0].motion.odom_from_robot, IsNear(Pose2{5.12, 0, 0}, 1e-9, 1e-9));
  EXPECT_FALSE(scans[1].motion.odom_from_robot.has_value());
  EXPECT_THAT(*scans[2].motion.odom_from_robot, IsNear(Pose2{0.1, 0, 0}, 1e-9, 1e-9));
  EXPECT_EQ(drops_["odometry restarted: ignored for one scan"], 1);
}

TEST_F(SensorSynchronizerTest, OverAGapTheGyroTurnsNothing) {
  const auto rate = [this](double seconds) {
    ImuSample sample;
    sample.utime = Utime::from_seconds(seconds);
    sample.angular_velocity_rad_per_s = {0, 0, 0.5};
    input_.add(sample);
  };
  const PoseBuffer& heading = input_.state().gyro_heading;
  for (int i = 0; i <= 10; ++i) rate(0.1 * i);
  EXPECT_NEAR(heading.newest_pose().theta_rad, 0.5, 1e-9);
  rate(1.7);
  EXPECT_EQ(drops_["imu: gap in time"], 1);
  EXPECT_EQ(heading.samples().size(), 1U);
  rate(1.8);
  EXPECT_NEAR(heading.newest_pose().theta_rad, 0.55, 1e-9);
  rate(1.7);
  EXPECT_EQ(drops_["imu: gap in time"], 2) << "nor where the stamp steps back";
  EXPECT_NEAR(heading.newest_pose().theta_rad, 0.55, 1e-9);
}

TEST_F(SensorSynchronizerTest, OfALaserOnTwoChannelsTheRawScansAreUsedAndEachOnce) {
  // The planar message comes first; raw ones come until 2 s; planar ones after that.
  for (int i = 0; i < 60; ++i) {
    scan(0.1 * i);
    if (i < 20) scan(0.1 * i, channels::kLidarRaw);
  }
  std::vector<std::string> channels_used;
  std::vector<Utime> stamps;
  for (const SynchronizedScan& scan : take()) {
    channels_used.push_back(scan.scan.channel);
    stamps.push_back(scan.scan.utime);
  }
  // Those of the second after the last raw scan are lost.
  ASSERT_EQ(stamps.size(), 50U);
  for (std::size_t i = 1; i < stamps.size(); ++i) EXPECT_GT(stamps[i], stamps[i - 1]);
  EXPECT_EQ(channels_used[0], "LIDAR");
  for (std::size_t i = 1; i < 20; ++i) EXPECT_EQ(channels_used[i], "LIDAR_RAW") << i;
  for (std::size_t i = 20; i < 50; ++i) EXPECT_EQ(channels_used[i], "LIDAR") << i;
}

TEST_F(SensorSynchronizerTest, SensorInfoOfALaserHoldsForItsRawChannelUnlessThatHasItsOwn) {
  SensorInfo info;
  info.channel = "LIDAR_FRONT";
  info.range_max_m = 20.0;
  input_.add(info);
  EXPECT_EQ(input_.sensor_of("LIDAR_RAW_FRONT")->range_max_m, 20.0);
  info.channel = "LIDAR_RAW_FRONT";
  info.range_max_m = 25.0;
  input_.add(info);
  EXPECT_EQ(input_.sensor_of("LIDAR_RAW_FRONT")->range_max_m, 25.0);
  EXPECT_EQ(input_.sensor_of("LIDAR_FRONT")->range_max_m, 20.0);
  EXPECT_EQ(input_.sensor_of("LIDAR_RAW_REAR"), nullptr);
}

// What lies behind the synchronizer knows nothing of calibrations.
TEST_F(SensorSynchronizerTest, ACalibrationCorrectsWhatComesIn) {
  SynchronizerOptions options;
  options.calibration.laser = {channels::kLidar, 0.3, 0.1, 90.0, false};
  options.calibration.odometry.left_scale = options.calibration.odometry.right_scale = 2.0;
  options.calibration.odometry.late_s = 0.1;
  options.calibration.gyro.scale = -1.0;
  input_ = SensorSynchronizer(options, {channels::kPanTiltState, &channels::lidar_of}, {});
  announce(channels::kLidar);
  ImuSample imu;
  imu.angular_velocity_rad_per_s.z() = 0.5;
  for (int i = 0; i <= 10; ++i) {
    imu.utime = Utime::from_seconds(0.1 * i);
    input_.add(imu);
    // At 1 m/s, and 100 ms late.
    odometry(0.1 * i + 0.1, {0.1 * i, 0, 0});
  }
  scan(0.45);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_THAT(*scans[0].motion.odom_from_robot, IsNear(Pose2{0.9, 0, 0}, 1e-6, 1e-6));
  EXPECT_NEAR(*scans[0].motion.gyro_heading_rad, -0.225, 1e-6);
  EXPECT_THAT(flatten(scans[0].robot_from_sensor),
              IsNear(Pose2{0.3, 0.1, deg_to_rad(90)}, 1e-9, 1e-9));
}

TEST_F(SensorSynchronizerTest, AScanThatComesTwiceIsUsedOnce) {
  odometry(0.0, {});
  odometry(2.0, {});
  for (const double seconds : {0.5, 0.5, 1.0, 1.5, 1.5}) scan(seconds);
  EXPECT_EQ(take().size(), 3U);
  EXPECT_EQ(drops_["duplicate scan"], 2);
}

TEST_F(SensorSynchronizerTest, ReturnsOfTheFloorAreNone) {
  SynchronizerOptions options;
  options.calibration.floor = {{channels::kLidar, 0.0, 1.5}};
  input_ = SensorSynchronizer(options, {channels::kPanTiltState, &channels::lidar_of}, {});
  announce(channels::kLidar);
  odometry(0.0, {});
  odometry(1.0, {});
  scan(0.5);  // ranges of 1 and 2 m
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].scan.ranges_m, (std::vector<float>{1.0F, 0.0F}));
}

TEST_F(SensorSynchronizerTest, NoMoreThanTwoHundredScansWait) {
  odometry(0.0, {});
  for (int i = 0; i < 1000; ++i) scan(1e-5 * i);
  EXPECT_EQ(input_.state().waiting.size(), 200U);
  EXPECT_EQ(take().size(), 800U);
}

TEST_F(SensorSynchronizerTest, OdometryInMillimetresIsNotUsedOnceThatIsKnown) {
  for (int i = 0; i < 40; ++i) odometry(0.1 * i, {30.0 * i, 0, 0});  // 0.3 m/s
  ASSERT_TRUE(input_.odometry_fault());
  EXPECT_EQ(drops_[*input_.odometry_fault()], 20);
  scan(3.9);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_FALSE(scans[0].motion.odom_from_robot);
}

TEST_F(SensorSynchronizerTest, ANewSessionKnowsNothingOfTheOneBefore) {
  odometry(0.0, {});
  odometry(0.1, {0.1, 0, 0});
  scan(0.15);
  input_.start_session();
  EXPECT_EQ(take().size(), 1U) << "what waited belongs to the one before";
  EXPECT_TRUE(input_.sensors().empty());
  announce(channels::kLidar);
  scan(0.2);
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_FALSE(scans[0].motion.odom_from_robot);
}

// Damaged messages must not stretch a scan without end.
TEST(DurationOf, AScanIsThatOfItsLastBeamUpToTenSeconds) {
  SensorInfo info;
  info.scan_duration_s = 0.1;
  LaserScan scan;
  EXPECT_EQ(duration_of(scan, info), 0.1);
  scan.time_offsets_s = {0.25F, 0.0F};
  EXPECT_EQ(duration_of(scan, info), 0.25);
  scan.time_offsets_s = {0.0F, 1e9F};
  EXPECT_EQ(duration_of(scan, info), 10.0);
  scan.time_offsets_s = {-1.0F, -2.0F};
  EXPECT_EQ(duration_of(scan, info), 0.0);
}

}  // namespace
}  // namespace marco
