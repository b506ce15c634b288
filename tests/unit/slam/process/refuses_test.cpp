// What a SlamAdapter refuses to believe of what anybody may send.
#include <gtest/gtest.h>

#include <algorithm>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

class SlamAdapterRefuses : public ::testing::Test {
 protected:
  void send(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus_.deliver(message.channel, message.bytes, message.utime);
  }
  LaserScan scan_at(double seconds, const Pose2& world_from_robot) const {
    LaserScan scan = room_.scan(world_from_robot);
    scan.utime = Utime::from_seconds(seconds);
    return scan;
  }
  testing::FlatWorld room_ = testing::small_room();
  process::BatchBus bus_;
};

// A message that anybody may send: the laser stays where it was said to be before.
TEST_F(SlamAdapterRefuses, ALaserIsNotMountedFarFromItsRobot) {
  SlamAdapter slam(bus_, {});
  send(SensorInfo{});
  for (int i = 0; i < 20; ++i) {
    if (i == 5) {
      SensorInfo far;
      far.parent_from_sensor = make_pose3({1e5, 1e5, 0.0});
      send(far);
    }
    send(scan_at(0.1 * i, {0.1 * i, 0, 0}));
  }
  slam.finish();
  EXPECT_EQ(slam.drops().by_cause().at("sensor_info_t: a sensor more than 20 m from its robot"), 1);
  EXPECT_NEAR(slam.live_trajectory().back().world_from_robot.x_m, 1.9, 0.03);
}

TEST_F(SlamAdapterRefuses, OfThousandsOfAnnouncedLasersAFewAreKept) {
  SlamAdapter slam(bus_, {});
  send(SensorInfo{});
  for (int i = 0; i < 2000; ++i) {
    SensorInfo info;
    info.channel = "LIDAR_" + std::to_string(i);
    send(info);
    LaserScan scan = scan_at(0.001 * i, {});
    scan.channel = info.channel;
    send(scan);
  }
  EXPECT_LE(slam.state().input.sensors.size(), 64U);
  EXPECT_GT(slam.drops().by_cause().at(kTooManySensors), 1900);
  const auto before = slam.live_trajectory().size();
  send(scan_at(3.0, {}));
  EXPECT_EQ(slam.live_trajectory().size(), before + 1);
}

TEST_F(SlamAdapterRefuses, RangesInMillimetresAreRefusedAndSaid) {
  SlamAdapter slam(bus_, {});
  SensorInfo info;
  info.range_max_m = 81000.0;
  send(info);
  for (int i = 0; i < 40; ++i) {
    LaserScan scan = scan_at(0.1 * i, {0.02 * i, 0, 0});
    for (float& range_m : scan.ranges_m) range_m *= 1000.0F;
    send(scan);
  }
  slam.finish();
  EXPECT_EQ(slam.live_trajectory().size(), 19U);  // then it is certain
  const auto& drops = slam.drops().by_cause();
  EXPECT_TRUE(std::any_of(drops.begin(), drops.end(), [](const auto& drop) {
    return drop.first.find("are these millimetres?") != std::string::npos && drop.second == 21;
  }));
}

}  // namespace
}  // namespace marco::slam
