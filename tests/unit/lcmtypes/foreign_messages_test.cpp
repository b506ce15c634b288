// Other systems' LCM messages as samples: MBot's two drivers of one laser, dimos' structs of ROS.
#include "recordings/foreign_messages.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "lcmtypes/convert.hpp"
#include "marco/ros_laser_scan_t.hpp"
#include "marco/ros_odometry_t.hpp"
#include "marco/ros_pose_stamped_t.hpp"
#include "tests/support/matchers.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;

constexpr int kBeams = 100;
constexpr int64_t kBeginUs = 1'500'000'000'000'000, kTurnUs = 150'000;
constexpr double kTurn = 2.0 * std::numbers::pi;
const char* const kLidarType = "89dc5b879a5056cf";

// An RPLidar turns clockwise: its own angle of beam i, and when it is measured.
double device_angle(int beam) { return kTurn * (beam + 0.5) / kBeams; }
int64_t time_us(int beam) { return kBeginUs + kTurnUs * beam / kBeams; }
float range_m(int beam) { return 1.0F + 0.01F * static_cast<float>(beam); }

lidar_raw_t empty_message(int beams) {
  lidar_raw_t message;
  message.num_ranges = beams;
  message.intensities.assign(static_cast<std::size_t>(beams), 0.0F);
  return message;
}

lidar_raw_t by_old_driver() {
  lidar_raw_t message = empty_message(kBeams);
  message.utime = kBeginUs;
  for (int beam = 0; beam < kBeams; ++beam) {
    message.ranges.push_back(range_m(beam));
    message.thetas.push_back(static_cast<float>(device_angle(beam)));
    message.times.push_back(time_us(beam));
  }
  return message;
}

// Counter-clockwise from 0, times along the array, the stamp that of the end of the turn.
lidar_raw_t by_driver_of_2023(int stride) {
  lidar_raw_t message = empty_message(kBeams / stride);
  message.utime = kBeginUs + kTurnUs;
  for (int i = 0; i < kBeams / stride; ++i) {
    const int beam = kBeams - 1 - i * stride;
    message.ranges.push_back(range_m(beam));
    message.thetas.push_back(static_cast<float>(kTurn - device_angle(beam)));
    message.times.push_back(kBeginUs + kTurnUs * i / kBeams);
  }
  return message;
}

ForeignChannel entry(bool direction_by_stamp) {
  ForeignChannel entry;
  entry.meaning = "lidar";
  entry.direction_by_stamp = direction_by_stamp;
  return entry;
}

LaserScan decode(const lidar_raw_t& message, bool direction_by_stamp = true) {
  ForeignMessages messages;
  return std::get<LaserScan>(messages.decode(encode_message(message), entry(direction_by_stamp)));
}

// Each beam, known by its range, lies and is measured where and when it was.
void expect_true_beams(const LaserScan& scan, double most_s) {
  EXPECT_NEAR(static_cast<double>(scan.utime.us - kBeginUs), 0.0, 1e6 * most_s);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const int beam = static_cast<int>(std::lround((scan.ranges_m[i] - 1.0F) / 0.01F));
    EXPECT_NEAR(normalize_angle(scan.bearing_rad(i) + device_angle(beam)), 0.0, 1e-5) << i;
    const double since_s = (scan.utime - Utime::from_us(time_us(beam))).seconds();
    EXPECT_NEAR(since_s + static_cast<double>(scan.time_offsets_s[i]), 0.0, most_s) << i;
  }
}

TEST(ForeignScan, OfAnMBotUntil2022HasTheDevicesOwnAnglesClockwise) {
  expect_true_beams(decode(by_old_driver()), 2e-6);
}

TEST(ForeignScan, OfAnMBotSince2023IsCounterClockwiseAndItsTimesRunAgainstTheMotion) {
  // A beam is 1.5 ms: half of it may be lost where the turn begins.
  expect_true_beams(decode(by_driver_of_2023(1)), 1.6e-3);
}

TEST(ForeignScan, WithAStrideIsMeasuredDuringTheWholeTurn) {
  expect_true_beams(decode(by_driver_of_2023(4)), 6.1e-3);
}

TEST(ForeignScan, WhoseBearingsFallWithTimeIsRightAsItIs) {
  lidar_raw_t message = by_old_driver();
  for (float& theta : message.thetas) theta = static_cast<float>(kTurn) - theta;
  expect_true_beams(decode(message), 2e-6);
}

TEST(ForeignScan, WithoutBeamTimesIsTakenForTheOldDrivers) {
  lidar_raw_t message = by_old_driver();
  for (int64_t& time : message.times) time = message.utime;
  const LaserScan scan = decode(message);
  EXPECT_NEAR(scan.bearing_rad(10), -device_angle(10), 1e-5);
}

TEST(ForeignScan, OfAnotherLaserStaysAsItIs) {
  const LaserScan scan = decode(by_old_driver(), false);
  EXPECT_NEAR(scan.bearing_rad(10), device_angle(10), 1e-5);
  EXPECT_EQ(scan.utime.us, kBeginUs);
}

TEST(ForeignScan, TheShippedTableLetsTheStampDecide) {
  const ForeignTable table;
  for (const char* channel : {"RPLIDAR_LASER", "LIDAR"}) {
    const ForeignChannel* found = entry_of(table, channel, kLidarType);
    ASSERT_NE(found, nullptr) << channel;
    EXPECT_TRUE(found->direction_by_stamp && !found->clockwise) << channel;
  }
  EXPECT_EQ(entry_of(table, "LIDAR", "0000000000000000"), nullptr);
}

ros_header_t header(int32_t seconds, int32_t ns) {
  ros_header_t header;
  header.seq = 7;
  header.stamp.sec = seconds;
  header.stamp.nsec = ns;
  header.frame_id = "base_link";
  return header;
}

TEST(ForeignScan, OfDimosTellsItsLimits) {
  ros_laser_scan_t message = {};
  message.header = header(1500, 250'000'000);
  message.angle_min = -1.0F;
  message.angle_increment = 0.5F;
  message.range_min = 0.2F;
  message.range_max = 12.0F;
  message.ranges = {1.0F, 2.0F, 3.0F};
  message.ranges_length = 3;
  const auto bytes = encode_message(message);
  ForeignMessages messages;
  const auto scan = std::get<LaserScan>(messages.decode(bytes, entry(false)));
  EXPECT_EQ(scan.utime.us, 1'500'250'000);
  EXPECT_EQ(utime_in(bytes), 1'500'250'000);
  EXPECT_NEAR(scan.bearing_rad(2), 0.0, 1e-6);
  const SensorInfo info = messages.info_of(scan, entry(false));
  EXPECT_NEAR(info.range_min_m, 0.2, 1e-6);
  EXPECT_NEAR(info.range_max_m, 12.0, 1e-6);
  EXPECT_EQ(info.channel, "LIDAR");
}

TEST(ForeignOdometry, OfDimosIsAPoseOnTheFloor) {
  ros_odometry_t odometry = {};
  odometry.header = header(2, 5'000);
  odometry.pose.pose.position.x = 1.5;
  odometry.pose.pose.orientation.z = std::sin(0.2);
  odometry.pose.pose.orientation.w = std::cos(0.2);
  ros_pose_stamped_t pose = {};
  pose.header = odometry.header;
  pose.pose = odometry.pose.pose;
  ForeignChannel entry;
  entry.meaning = "odometry";
  ForeignMessages messages;
  for (const auto& bytes : {encode_message(odometry), encode_message(pose)}) {
    const auto sample = std::get<OdometrySample>(messages.decode(bytes, entry));
    EXPECT_THAT(sample.odom_from_robot, IsNear(Pose2{1.5, 0.0, 0.4}, 1e-9, 1e-9));
    EXPECT_EQ(sample.utime.us, 2'000'005);
    EXPECT_EQ(utime_in(bytes), 2'000'005);
  }
}

TEST(ForeignMessages, RefuseWhatDoesNotDecode) {
  ForeignMessages messages;
  const std::vector<uint8_t> cut(20, 0);
  for (const char* meaning : {"lidar", "odometry", "encoders"}) {
    ForeignChannel entry;
    entry.meaning = meaning;
    EXPECT_THROW(messages.decode(cut, entry), std::invalid_argument) << meaning;
  }
  EXPECT_EQ(utime_in(std::vector<uint8_t>(10, 0)), std::nullopt);
}

}  // namespace
}  // namespace marco
