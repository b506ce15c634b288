#include "slam/process/slam_adapter.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

class SlamAdapterTest : public ::testing::Test {
 protected:
  SlamAdapterTest() {
    bus_.subscribe<slam_pose_t>(channels::kSlamPose, heard_,
                                [this](const auto& pose, const auto&) { poses_.push_back(pose); });
    bus_.subscribe<trajectory_t>(channels::kTrajectory, heard_,
                                 [this](const auto&, const auto&) { ++trajectories_; });
    bus_.subscribe<grid_map_t>(channels::kGridMap, heard_,
                               [this](const auto&, const auto&) { ++tiles_; });
  }
  void send(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus_.deliver(message.channel, message.bytes, message.utime);
  }
  void send_info(SensorInfo::Mount mount = SensorInfo::Mount::robot) {
    SensorInfo info;
    info.mount = mount;
    info.parent_from_sensor = make_pose3({0.1, 0.0, 0.3});
    send(info);
    SensorInfo base;
    base.channel = channels::kPanTiltState;
    send(base);
  }
  LaserScan scan_at(double seconds, const Pose2& world_from_robot) {
    LaserScan scan = room_.scan(world_from_robot * Pose2{0.1, 0, 0});
    scan.utime = Utime::from_seconds(seconds);
    return scan;
  }
  // A laser that turns as fast as it publishes: the robot is elsewhere at each beam.
  LaserScan slow_scan_at(double seconds,
                         double duration_s,
                         const std::function<Pose2(double)>& pose) {
    LaserScan scan = scan_at(seconds, pose(seconds));
    for (std::size_t beam = 0; beam < scan.size(); ++beam) {
      const double at_s = duration_s * static_cast<double>(beam) / static_cast<double>(scan.size());
      const Pose2 laser = pose(seconds + at_s) * Pose2{0.1, 0, 0};
      const double bearing_rad = laser.theta_rad + scan.bearing_rad(beam);
      scan.ranges_m[beam] = static_cast<float>(room_.range_m(laser.translation_m(), bearing_rad));
    }
    return scan;
  }
  OdometrySample odometry_at(double seconds, const Pose2& pose) {
    OdometrySample sample;
    sample.utime = Utime::from_seconds(seconds);
    sample.odom_from_robot = pose;
    return sample;
  }

  // Stands, turns and stands again, with a laser that takes its whole period for a scan.
  void stand_after_a_turn(bool with_odometry, double within_m, double within_deg) {
    constexpr double kPeriodS = 0.15;
    const auto pose = [](double seconds) {
      return Pose2{0, 0, 1.2 * std::clamp(seconds - 0.6, 0.0, 1.5)};
    };
    SlamAdapter slam(bus_, {});
    SensorInfo info;
    info.parent_from_sensor = make_pose3({0.1, 0.0, 0.3});
    info.scan_duration_s = kPeriodS;
    send(info);
    for (int i = 0; i < 30; ++i) {
      const double at_s = kPeriodS * i;
      for (int k = 0; with_odometry && k < 5; ++k) {
        const double then_s = at_s + kPeriodS * k / 5;
        send(odometry_at(then_s, pose(then_s)));
      }
      send(slow_scan_at(at_s, kPeriodS, pose));
    }
    slam.finish();
    bus_.deliver_published();
    ASSERT_EQ(poses_.size(), 30U);
    for (std::size_t i = 20; i < poses_.size(); ++i) {
      EXPECT_NEAR(poses_[i].theta_rad, 1.8, deg_to_rad(within_deg)) << i;
      EXPECT_NEAR(poses_[i].theta_rad, poses_[i - 1].theta_rad, deg_to_rad(0.2)) << i;
      EXPECT_NEAR(std::hypot(poses_[i].x_m, poses_[i].y_m), 0.0, within_m) << i;
    }
  }

  testing::FlatWorld room_ = testing::small_room();
  process::BatchBus bus_;
  process::DropCounter heard_;
  std::vector<slam_pose_t> poses_;
  int trajectories_ = 0;
  int tiles_ = 0;
};

TEST_F(SlamAdapterTest, AScanWaitsForOdometryBeyondItsTime) {
  SlamAdapter slam(bus_, {});
  send_info();
  send(odometry_at(0.0, {}));
  send(scan_at(0.1, {}));
  EXPECT_TRUE(poses_.empty());
  send(odometry_at(0.2, {0.1, 0, 0}));
  ASSERT_EQ(poses_.size(), 1U);
  EXPECT_EQ(poses_[0].utime, 100000);
  // Half way between both odometry samples.
  EXPECT_THAT(slam.odometry_trajectory().at(0).world_from_robot,
              IsNear(Pose2{0.05, 0, 0}, 1e-9, 1e-9));
}

TEST_F(SlamAdapterTest, WhereOdometryFallsSilentScansGoOnWithoutIt) {
  SlamAdapter slam(bus_, {});
  send_info();
  send(odometry_at(0.0, {}));
  for (int i = 1; i <= 20; ++i) send(scan_at(0.1 * i, {0.01 * i, 0, 0}));
  // Those within the patience of half a second waited; the later ones did not.
  EXPECT_EQ(poses_.size(), 20U);
  EXPECT_NEAR(poses_.back().x_m, 0.19, 0.02);
}

// A base that was killed counts from zero when it is back; between its last and its first word lie
// scans that must not be taken to have moved on the way there.
TEST_F(SlamAdapterTest, OdometryThatBeginsAnewMovesNothing) {
  SlamAdapter slam(bus_, {});
  send_info();
  const auto way = [](int i) { return Pose2{0.02 * i, 0, 0}; };
  for (int i = 0; i < 40; ++i) {
    const double at_s = 0.05 * i;
    send(scan_at(at_s, way(i)));
    // Silent for a quarter of a second.
    if (i >= 20 && i < 25) continue;
    // Once far off, and once turned on the spot.
    const Pose2 begun = i < 20 ? Pose2{5.0, 2.0, 0.3}
                        : i < 32
                            ? Pose2{-0.5, 0, 0}
                            : Pose2{-0.5, 0, 0} * way(32) * Pose2{0, 0, 2.1} * way(32).inverse();
    send(odometry_at(at_s, begun * way(i)));
  }
  slam.finish();
  ASSERT_EQ(poses_.size(), 40U);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Pose2 truth = way(static_cast<int>(i));
    EXPECT_NEAR(std::hypot(poses_[i].x_m - truth.x_m, poses_[i].y_m), 0.0, 0.02) << i;
    EXPECT_NEAR(poses_[i].theta_rad, 0.0, deg_to_rad(0.5)) << i;
  }
  EXPECT_EQ(slam.drops().by_cause().at("odometry restarted: ignored for one scan"), 2);
}

// One robot, one port: a second robot's scans are not sorted out, but they meet the innovation gate
// like any bad scan, and are noticed.
TEST_F(SlamAdapterTest, ASecondSenderOnOurChannelIsNoticedAndDoesNotMoveUs) {
  SlamAdapter slam(bus_, {});
  send_info();
  const auto way = [](int i) { return Pose2{0.5 * std::sin(0.02 * i), 0, 0}; };
  for (int i = 0; i < 200; ++i) {
    send(odometry_at(0.05 * i, way(i)));
    send(scan_at(0.05 * i, way(i)));
    if (i >= 60) send(scan_at(0.05 * i + 0.02, {1.5, -0.7, 2.5}));
  }
  EXPECT_THAT(slam.state_line(), ::testing::HasSubstr("is there a second sender?"));
  slam.finish();
  bus_.deliver_published();
  ASSERT_EQ(poses_.size(), 340U);
  for (const slam_pose_t& pose : poses_) {
    if (pose.utime % 50000 != 0) continue;
    const Pose2 truth = way(static_cast<int>(pose.utime / 50000));
    EXPECT_NEAR(std::hypot(pose.x_m - truth.x_m, pose.y_m), 0.0, 0.05) << pose.utime;
  }
}

// A match's error deskews the next scan wrongly, which is matched as wrong the other way.
TEST_F(SlamAdapterTest, ASlowLasersScansDoNotSwingAfterATurn) {
  stand_after_a_turn(true, 0.02, 0.5);
}

// The turn itself is then seen late, as its beginning and its end were.
TEST_F(SlamAdapterTest, ASlowLasersScansDoNotSwingWithoutOdometry) {
  stand_after_a_turn(false, 0.04, 2.0);
}

TEST_F(SlamAdapterTest, WithoutSensorInfoAScanIsDroppedAndSaid) {
  SlamAdapter slam(bus_, {});
  send(scan_at(0.1, {}));
  EXPECT_TRUE(poses_.empty());
  EXPECT_EQ(slam.drops().by_cause().at("no SENSOR_INFO for LIDAR yet"), 1);
}

TEST_F(SlamAdapterTest, ATiltedScanIsCarriedAndALevelOneMatched) {
  SlamAdapter slam(bus_, {});
  send_info(SensorInfo::Mount::pantilt);
  PanTiltState state;
  for (int i = 0; i < 4; ++i) {
    state.utime = Utime::from_seconds(0.1 * i);
    state.tilt_rad = i < 2 ? 0.0 : deg_to_rad(10.0);
    send(state);
    send(scan_at(0.1 * i, {}));
  }
  ASSERT_EQ(poses_.size(), 4U);
  EXPECT_EQ(poses_[1].status, int{slam_pose_t::STATUS_MATCHED});
  EXPECT_EQ(poses_[2].status, int{slam_pose_t::STATUS_PREDICTED});
}

TEST_F(SlamAdapterTest, MapsAreSentInTheEndAndOnRequest) {
  SlamAdapterOptions options;
  options.map_period_s = 0.0;
  SlamAdapter slam(bus_, options);
  send_info();
  for (int i = 0; i < 10; ++i) send(scan_at(0.1 * i, {0.1 * i, 0, 0}));
  EXPECT_EQ(tiles_, 0);
  map_request_t request{};
  request.channel = channels::kGridMap;
  bus_.deliver(channels::kMapRequest, encode_message(request), {});
  EXPECT_EQ(tiles_, 1);
  EXPECT_EQ(trajectories_, 0);
  slam.finish();
  bus_.deliver_published();
  EXPECT_EQ(tiles_, 2);
  EXPECT_EQ(trajectories_, 1);
}

TEST_F(SlamAdapterTest, EverySecondScanIsHeldOutOfTheMap) {
  SlamAdapterOptions options;
  options.hold_out_every = 2;
  SlamAdapter slam(bus_, options);
  slam.keep_scans();
  send_info();
  // Each far enough from the one before to be a keyframe.
  for (int i = 0; i < 8; ++i) {
    send(odometry_at(0.5 * i, {0.35 * i, 0, 0}));
    send(scan_at(0.5 * i, {-2.0 + 0.35 * i, 0, 0}));
  }
  slam.finish();
  ASSERT_EQ(slam.scans().size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(slam.scans()[i].held_out, i % 2 == 1) << i;
    EXPECT_EQ(slam.scans()[i].hits_in_robot.cols() > 0, i % 2 == 1) << i;
  }
  std::vector<Utime> drawn;
  for (const Keyframe& key : slam.session().keys()) drawn.push_back(key.utime);
  EXPECT_EQ(drawn, (std::vector<Utime>{Utime::from_seconds(0.0), Utime::from_seconds(1.0),
                                       Utime::from_seconds(2.0), Utime::from_seconds(3.0)}));
}

TEST_F(SlamAdapterTest, GarbageOnAnyChannelIsCountedAndHarmsNobody) {
  SlamAdapter slam(bus_, {});
  send_info();
  std::mt19937 random(4);
  for (const char* channel :
       {channels::kLidar, channels::kOdometry, channels::kImu, channels::kSensorInfo,
        channels::kPanTiltState, channels::kMapRequest}) {
    for (int i = 0; i < 200; ++i) {
      std::vector<uint8_t> bytes(random() % 100);
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
      bus_.deliver(channel, bytes, {});
    }
  }
  EXPECT_GT(slam.drops().by_cause().at("undecodable"), 1000);
  LaserScan empty;
  empty.utime = Utime::from_us(5);
  send(empty);
  send(scan_at(0.1, {}));
  EXPECT_EQ(poses_.size(), 2U);
}

}  // namespace
}  // namespace marco::slam
