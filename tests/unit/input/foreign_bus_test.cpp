// Other systems' sensors on the network, heard as Marco's.
#include "live/foreign_bus.hpp"

#include <gmock/gmock.h>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/mbot_pose2d_t.hpp"

namespace marco {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class ForeignSensors : public ::testing::Test {
 protected:
  ForeignSensors()
      : inner_("memq://"), bus_(inner_, {}, [this](const auto& line) { said_.push_back(line); }) {
    for (const char* channel :
         {channels::kLidarPattern, channels::kOdometry, channels::kSensorInfo}) {
      bus_.subscribe_raw(channel, [this](const process::RawMessage& raw) {
        heard_.emplace_back(raw.channel);
        bytes_.assign(raw.bytes.begin(), raw.bytes.end());
      });
    }
  }
  template <class Message>
  void hear(const std::string& channel, const Message& message) {
    inner_.publish_raw(channel, encode_message(message), {});
    while (inner_.handle_once(0)) {
    }
  }
  static lidar_raw_t scan_at(int64_t utime_us) {
    LaserScan scan;
    scan.utime = Utime::from_us(utime_us);
    scan.ranges_m = {1.0F, 2.0F, 3.0F};
    scan.bearings_rad = {0.1F, 0.2F, 0.3F};
    scan.time_offsets_s = {0.0F, 0.1F, 0.2F};
    return to_raw_message(scan);
  }
  static bot_core::planar_lidar_t planar_at(int64_t utime_us) {
    LaserScan scan;
    scan.utime = Utime::from_us(utime_us);
    scan.ranges_m = {1.0F, 2.0F};
    scan.bearing_step_rad = 0.5;
    return to_message(scan);
  }
  static mbot_pose2d_t pose_at(int64_t utime_us, float x) {
    mbot_pose2d_t pose = {};
    pose.utime = utime_us;
    pose.x = x;
    return pose;
  }

  process::LcmBus inner_;
  std::vector<std::string> said_;
  ForeignBus bus_;
  std::vector<std::string> heard_;
  std::vector<uint8_t> bytes_;
};

TEST_F(ForeignSensors, AreHeardOnMarcosChannels) {
  hear("RPLIDAR_LASER", scan_at(1'000'000));
  EXPECT_THAT(heard_, ElementsAre("SENSOR_INFO", "LIDAR_RAW"));
  const auto scan = std::get<LaserScan>(*decode_sample("LIDAR_RAW", bytes_));
  EXPECT_NEAR(scan.bearing_rad(1), -0.2, 1e-6);
  hear("MBOT_ODOMETRY", pose_at(1'000'000, 2.5F));
  EXPECT_EQ(heard_.back(), "ODOMETRY");
  const auto odometry = std::get<OdometrySample>(*decode_sample("ODOMETRY", bytes_));
  EXPECT_NEAR(odometry.odom_from_robot.x_m, 2.5, 1e-6);
  ASSERT_THAT(said_, SizeIs(2));
  EXPECT_THAT(said_[0], HasSubstr("RPLIDAR_LASER"));
}

TEST_F(ForeignSensors, AnnounceTheLaserOnceASecond) {
  for (int i = 0; i < 25; ++i) hear("RPLIDAR_LASER", scan_at(1'000'000 + 100'000 * i));
  EXPECT_EQ(std::count(heard_.begin(), heard_.end(), "SENSOR_INFO"), 3);
  EXPECT_EQ(std::count(heard_.begin(), heard_.end(), "LIDAR_RAW"), 25);
}

TEST_F(ForeignSensors, OnMarcosOwnNameAreKnownByTheirType) {
  hear("LIDAR", scan_at(1'000'000));  // MBot's, since 2023
  EXPECT_THAT(heard_, ElementsAre("SENSOR_INFO", "LIDAR_RAW"));
}

TEST_F(ForeignSensors, OfMarcosTypeOnItsOwnChannelAreOurs) {
  hear("LIDAR_RAW", scan_at(1'000'000));
  hear("LIDAR_FRONT", planar_at(1'000'000));
  EXPECT_THAT(heard_, ElementsAre("LIDAR_RAW", "LIDAR_FRONT"));
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(ForeignSensors, AreNotHeardBesideOneOfMarcosLasers) {
  hear("SENSOR_INFO", to_message(SensorInfo{}));
  heard_.clear();
  hear("LIDAR", planar_at(1'000'000));
  hear("LIDAR", planar_at(4'000'000));
  hear("RPLIDAR_LASER", scan_at(4'000'000));
  EXPECT_THAT(heard_, ElementsAre("LIDAR", "LIDAR"));
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(ForeignSensors, OfOneKindDoNotMix) {
  hear("SICK_FRONT", planar_at(1'000'000));
  hear("HOKUYO", planar_at(1'000'000));
  hear("MBOT_ODOMETRY", pose_at(1'000'000, 1.0F));
  hear("ODOMETRY", pose_at(1'000'000, 2.0F));
  EXPECT_THAT(bus_.used(), ElementsAre(::testing::Pair("MBOT_ODOMETRY", ::testing::_),
                                       ::testing::Pair("SICK_FRONT", ::testing::_)));
  // The second odometry is left to the handlers of ODOMETRY, which know it by its type.
  EXPECT_THAT(heard_, ElementsAre("SENSOR_INFO", "LIDAR", "ODOMETRY", "ODOMETRY"));
}

TEST_F(ForeignSensors, ThatDoNotDecodeAreCounted) {
  std::vector<uint8_t> cut = encode_message(scan_at(1'000'000));
  cut.resize(30);
  inner_.publish_raw("RPLIDAR_LASER", cut, {});
  while (inner_.handle_once(0)) {
  }
  EXPECT_EQ(bus_.drops().dropped(), 1);
  EXPECT_THAT(heard_, IsEmpty());
  EXPECT_THAT(bus_.used(), IsEmpty());
}

}  // namespace
}  // namespace marco
