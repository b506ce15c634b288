// Logs of ours as recordings of ROS, read back as other people's; and from one ROS to the other.
#include "tools/log/ros_export.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <set>

#include "bot_core/image_t.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/known_types.hpp"
#include "recordings/ros/open_messages.hpp"
#include "tests/support/recorded.hpp"
#include "tools/log/mcap_sink.hpp"
#include "tools/log/ros_copy.hpp"
#include "tools/log/slam_results.hpp"

namespace marco::logs {
namespace {

using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::testing::Contains;
using ::testing::UnorderedElementsAre;

Utime at(double seconds) { return Utime::from_us(kStartUs) + Duration::from_seconds(seconds); }

// A robot whose laser sits turned ahead of the middle.
std::vector<Sample> drive() {
  SensorInfo info;
  info.utime = at(0.0);
  info.parent_from_sensor = make_pose3({0.25, 0.0, 0.3}, 0.0, 0.0, 0.5);
  info.range_max_m = 8.0;
  info.scan_duration_s = 0.02;
  std::vector<Sample> samples{info};
  for (int i = 0; i < 20; ++i) {
    OdometrySample odometry;
    odometry.utime = at(0.1 * i);
    odometry.odom_from_robot = {0.1 * i, 0.0, 0.01 * i};
    samples.emplace_back(odometry);
    ImuSample imu;
    imu.utime = at(0.1 * i);
    imu.angular_velocity_rad_per_s.z() = 0.1;
    samples.emplace_back(imu);
    LaserScan scan;
    scan.utime = at(0.1 * i + 0.01);
    scan.first_bearing_rad = -1.0;
    scan.bearing_step_rad = 0.02;
    scan.ranges_m.assign(101, 2.0F);
    scan.ranges_m[7] = 0.0F;
    scan.ranges_m[8] = 9.0F;
    samples.emplace_back(scan);
  }
  return samples;
}

std::set<std::string> topics_of(const std::string& path) {
  const auto source = ros::open_messages(path);
  std::set<std::string> topics;
  while (const auto message = source->next()) {
    topics.insert(message->topic->name + " " + message->topic->type);
  }
  return topics;
}

enum class Kind { bag, ros1, ros2 };

std::unique_ptr<ros::MessageSink> sink_of(Kind kind, OutputFile& out) {
  if (kind == Kind::bag) return std::make_unique<ros::BagWriter>(out);
  return std::make_unique<McapSink>(out, kind == Kind::ros1 ? "ros1" : "cdr");
}

void write_drive(const std::string& path, Kind kind) {
  OutputFile out(path, Existing::replace, {});
  const auto sink = sink_of(kind, out);
  RosExport ros(*sink);
  for (const Sample& sample : drive()) ros.add(sample);
  sink->finish();
  out.finish();
}

class AsRos : public ::testing::TestWithParam<Kind> {
 protected:
  const ScratchFolder folder_;
  const std::string path_ = folder_ / "out";
};
INSTANTIATE_TEST_SUITE_P(Kinds, AsRos, ::testing::Values(Kind::bag, Kind::ros1, Kind::ros2));

TEST_P(AsRos, ADriveComesBackAsItWas) {
  write_drive(path_, GetParam());
  const Recorded recorded = read_all(*open_recording(path_));
  ASSERT_EQ(recorded.scans.size(), 20U);
  EXPECT_EQ(recorded.scans[3].utime, at(0.31));
  EXPECT_NEAR(recorded.scans[3].bearing_rad(0), -1.0, 1e-6);
  EXPECT_EQ(recorded.scans[3].ranges_m[6], 2.0F);
  EXPECT_FALSE(recorded.scans[3].ranges_m[7] < 8.0F);  // no returns
  EXPECT_FALSE(recorded.scans[3].ranges_m[8] < 8.0F);
  ASSERT_EQ(recorded.odometry.size(), 20U);
  EXPECT_NEAR(recorded.odometry[5].odom_from_robot.theta_rad, 0.05, 1e-12);
  EXPECT_EQ(recorded.imu.size(), 20U);
  ASSERT_EQ(recorded.infos.size(), 1U);
  EXPECT_TRUE(recorded.infos[0].parent_from_sensor.isApprox(
      std::get<SensorInfo>(drive()[0]).parent_from_sensor, 1e-9));
  EXPECT_NEAR(recorded.infos[0].scan_duration_s, 0.02, 1e-6);
}

TEST_P(AsRos, WhatSlamMadeIsThereToo) {
  {
    files::EventLogWriter log(folder_ / "slam.lcm");
    const auto write = [&](const char* channel, const auto& message, double seconds) {
      log.write(channel, encode_message(message), at(seconds));
    };
    PoseEstimate pose;
    pose.utime = at(0.5);
    pose.world_from_robot = {1.0, 1.0, 0.0};
    write("SLAM_POSE", to_message(pose), 0.52);
    GridMap map;
    map.origin_m = {-1.0, -2.0};
    map.width_cells = 300;
    map.height_cells = 2;
    map.occupancy.assign(600, GridMap::kUnknown);
    map.occupancy[299] = 100;
    for (const grid_map_t& tile : to_messages(map, at(0.6), 1)) write("GRID_MAP", tile, 0.62);
    write("TRAJECTORY", to_message(Trajectory{{at(0.5), {1.0, 1.0, 0.0}}}, at(0.6), 1), 0.63);
    bot_core::image_t image{};
    image.utime = at(0.7).us;
    image.width = 2;
    image.height = 1;
    image.row_stride = 8;
    image.pixelformat = bot_core::image_t::PIXEL_FORMAT_BGR;
    image.data = {1, 2, 3, 4, 5, 6, 0, 0};
    image.size = 8;
    write("CAMERA", image, 0.7);
    image.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
    write("CAMERA", image, 0.8);
  }
  OutputFile out(path_, Existing::replace, {});
  const auto sink = sink_of(GetParam(), out);
  RosExport ros(*sink);
  SlamResults results(folder_ / "slam.lcm", ros);
  results.write_until(at(0.5));
  EXPECT_EQ(ros.messages(), 2);  // the pose, and where it says that the robot is
  results.write_until(at(10.0));
  sink->finish();
  out.finish();
  EXPECT_THAT(topics_of(path_),
              UnorderedElementsAre("/slam_pose geometry_msgs/PoseStamped", "/tf tf2_msgs/TFMessage",
                                   "/map nav_msgs/OccupancyGrid", "/trajectory nav_msgs/Path",
                                   "/camera/image_raw sensor_msgs/Image",
                                   "/camera/image_raw/compressed sensor_msgs/CompressedImage"));
  const auto source = ros::open_messages(path_);
  source->select([](const ros::Topic& topic) { return topic.name == "/map"; });
  const auto map = source->next();
  ASSERT_TRUE(map);
  EXPECT_EQ(map->bytes.back(), 255U);
  EXPECT_EQ(map->bytes[map->bytes.size() - 301], 100U);  // two tiles are one map
  EXPECT_FALSE(source->next());
}

TEST_P(AsRos, AnotherRosTakesKnownTypes) {
  write_drive(folder_ / "in", GetParam());
  for (const Kind kind : {Kind::bag, Kind::ros1, Kind::ros2}) {
    const auto source = ros::open_messages(folder_ / "in");
    OutputFile out(path_, Existing::replace, {});
    const auto sink = sink_of(kind, out);
    const RosCopyResult result = copy_messages(*source, *sink, ignore_progress);
    sink->finish();
    out.finish();
    EXPECT_EQ(result.messages, 81);
    EXPECT_TRUE(result.left_out.empty());
    const Recorded recorded = read_all(*open_recording(path_));
    ASSERT_EQ(recorded.scans.size(), 20U);
    EXPECT_EQ(recorded.scans[3].utime, at(0.31));
    EXPECT_EQ(recorded.odometry.size(), 20U);
  }
}

TEST(RosCopy, SaysWhatAnotherRosDoesNotHave) {
  const ScratchFolder folder;
  {
    OutputFile out(folder / "in.bag", Existing::refuse, {});
    ros::BagWriter bag(out);
    ros::Topic topic;
    topic.name = "/own";
    topic.type = "my_msgs/Own";
    topic.md5 = std::string(32, 'a');
    topic.schema = "uint8 x\n";
    bag.write(bag.add_topic(topic), 1, 1, std::vector<uint8_t>{7});
    topic.type = "std_msgs/String";
    topic.name = "/broken";
    bag.write(bag.add_topic(topic), 2, 2, std::vector<uint8_t>{255, 0, 0, 0, 'x'});
    bag.finish();
    out.finish();
  }
  OutputFile out(folder / "out.mcap", Existing::refuse, {});
  McapSink sink(out, "cdr");
  const auto source = ros::open_messages(folder / "in.bag");
  const RosCopyResult result = copy_messages(*source, sink, ignore_progress);
  EXPECT_EQ(result.messages, 0);
  EXPECT_THAT(result.left_out,
              UnorderedElementsAre(std::pair("my_msgs/Own (ros1) is not known in ROS 2", 1),
                                   std::pair("broken messages of /broken", 1)));
  // As it is, it goes into any file of ROS 1.
  OutputFile same(folder / "same.mcap", Existing::refuse, {});
  McapSink ros1(same, "ros1");
  source->rewind();
  EXPECT_EQ(copy_messages(*source, ros1, ignore_progress).messages, 2);
}

// The recorder keeps such a topic's last message for late listeners.
TEST(McapSink, SaysWhatLateListenersAreGiven) {
  const ros::Topic statics = topic_of("/tf_static", "tf2_msgs/TFMessage", "cdr");
  EXPECT_THAT(statics.metadata.at("offered_qos_profiles"), ::testing::HasSubstr("durability: 1"));
  EXPECT_EQ(topic_of("/scan", "sensor_msgs/LaserScan", "cdr").metadata.at("offered_qos_profiles"),
            "");
}

}  // namespace
}  // namespace marco::logs
