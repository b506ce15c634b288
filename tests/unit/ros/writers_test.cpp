// What we write, read back by our own readers; other people's read it in tests/peers.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/encode_messages.hpp"
#include "recordings/ros/known_types.hpp"
#include "recordings/ros/open_messages.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::RosWriter;
using ::marco::testing::TemporaryFolder;
using ::testing::Each;
using ::testing::ElementsAre;

Message message_of(const Topic& topic, const Bytes& bytes) { return {&topic, 0, 0, bytes}; }

Topic topic_of_type(const std::string& type, const std::string& encoding) {
  Topic topic;
  topic.name = "/topic";
  topic.type = type;
  topic.encoding = encoding;
  return topic;
}

class InBothEncodings : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Ros, InBothEncodings, ::testing::Values("ros1", "cdr"));

TEST_P(InBothEncodings, ValuesComeBackAsTheyWere) {
  const std::string encoding = GetParam();
  LaserScanMessage scan;
  scan.header = {1'500'000'001, "lidar"};
  scan.angle_min = -1.0F;
  scan.angle_increment = 0.5F;
  scan.range_max = 8.0F;
  scan.ranges = {1.0F, 2.5F, std::numeric_limits<float>::infinity()};
  const Topic scans = topic_of_type("sensor_msgs/LaserScan", encoding);
  const LaserScanMessage read = decode_scan(message_of(scans, encode(encoding, scan)));
  EXPECT_EQ(read.header.stamp_ns, 1'500'000'001);
  EXPECT_EQ(read.header.frame_id, "lidar");
  EXPECT_EQ(read.angle_increment, 0.5F);
  EXPECT_EQ(read.ranges, scan.ranges);

  OdometryMessage odometry;
  odometry.header = {2'000'000'000, "odom"};
  odometry.child_frame_id = "base_link";
  odometry.pose = lift({1.0, 2.0, 0.5});
  odometry.angular.z() = -0.25;
  const Topic odometries = topic_of_type("nav_msgs/Odometry", encoding);
  const OdometryMessage moved = decode_odometry(message_of(odometries, encode(encoding, odometry)));
  EXPECT_TRUE(moved.pose.isApprox(odometry.pose, 1e-12));
  EXPECT_EQ(moved.child_frame_id, "base_link");
  EXPECT_EQ(moved.angular.z(), -0.25);

  const std::vector<TransformMessage> tree{{{5, "a"}, "bc", lift({3.0, 0.0, 0.0})},
                                           {{6, "bc"}, "d", Pose3::Identity()}};
  const Topic transforms = topic_of_type("tf2_msgs/TFMessage", encoding);
  const auto both = decode_transforms(message_of(transforms, encode(encoding, tree)));
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[1].child_frame_id, "d");
  EXPECT_EQ(both[0].parent_from_child.translation().x(), 3.0);

  ImuMessage imu;
  imu.angular_velocity = {0.1, 0.2, 0.3};
  imu.has_acceleration = false;
  const Topic imus = topic_of_type("sensor_msgs/Imu", encoding);
  const ImuMessage turned = decode_imu(message_of(imus, encode(encoding, imu)));
  EXPECT_EQ(turned.angular_velocity.z(), 0.3);
  EXPECT_TRUE(turned.has_angular_velocity);
  EXPECT_FALSE(turned.has_acceleration);
}

// Every known type within another, arrays of all kinds, alignment of both.
Bytes camera_info(RosWriter::Form form) {
  RosWriter out(form);
  out.header(1.25, "cam").numbers(std::vector<uint32_t>{480, 640}).text("plumb_bob");
  out.number(uint32_t{5}).numbers(std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5});
  out.numbers(std::vector<double>(9, 1.5)).numbers(std::vector<double>(9, 2.5));
  out.numbers(std::vector<double>(12, 3.5)).numbers(std::vector<uint32_t>{1, 2, 3, 4, 5, 6});
  out.number(uint8_t{1});
  return out.bytes();
}

Bytes joint_state(RosWriter::Form form) {
  RosWriter out(form);
  out.header(1.25, "").number(uint32_t{2}).text("pan").text("tilt");
  out.number(uint32_t{2}).numbers(std::vector<double>{0.5, -0.5});
  return out.number(uint32_t{0}).number(uint32_t{0}).bytes();
}

Bytes echoes(RosWriter::Form form) {
  RosWriter out(form);
  out.header(1.25, "laser").numbers(std::vector<float>(7, 0.5F)).number(uint32_t{2});
  out.number(uint32_t{2}).numbers(std::vector<float>{1.0F, 2.0F}).number(uint32_t{0});
  return out.number(uint32_t{0}).bytes();
}

TEST(KnownTypes, AreTheSameInBothEncodings) {
  using Make = Bytes (*)(RosWriter::Form);
  const std::pair<const char*, Make> samples[] = {
      {"sensor_msgs/CameraInfo", camera_info},
      {"sensor_msgs/JointState", joint_state},
      {"sensor_msgs/MultiEchoLaserScan", echoes},
  };
  for (const auto& [name, make] : samples) {
    const auto& type = *known_type(name);
    const Bytes packed = make(RosWriter::Form::ros1), cdr = make(RosWriter::Form::cdr);
    const auto transcoded = [&](const Bytes& bytes, const char* from, const char* to) {
      WireReader in = WireReader::of(from, bytes);
      WireWriter out(to);
      transcode(type, in, out);
      in.finish();
      return out.bytes();
    };
    EXPECT_EQ(transcoded(packed, "ros1", "cdr"), cdr) << name;
    EXPECT_EQ(transcoded(cdr, "cdr", "ros1"), packed) << name;
    Bytes cut = packed;
    cut.resize(cut.size() - 1);
    EXPECT_THROW(transcoded(cut, "ros1", "cdr"), WireError) << name;
  }
}

TEST(KnownTypes, TellTheirDefinitionAsEachRosWritesIt) {
  const KnownType& path = *known_type("nav_msgs/Path");
  const std::string ros1 = definition_text(path, "ros1"), ros2 = definition_text(path, "cdr");
  EXPECT_THAT(ros1,
              ::testing::StartsWith("std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"));
  EXPECT_THAT(ros1, ::testing::HasSubstr("MSG: std_msgs/Header\nuint32 seq\ntime stamp\n"));
  EXPECT_THAT(ros2,
              ::testing::HasSubstr("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"));
  EXPECT_THAT(ros2, ::testing::Not(::testing::HasSubstr("seq")));
  EXPECT_EQ(known_type("nav_msgs/Pfad"), nullptr);
}

class WrittenBag : public ::testing::Test {
 protected:
  // `count` messages on two topics, times out of order here and there.
  void write(int count, std::size_t bytes_each) {
    files::OutputFile out(path_);
    BagWriter bag(out);
    Topic topic = topic_of_type("std_msgs/String", "ros1");
    topic.md5 = "992ce8a1687cec8c8bd883ec73ca41d1";
    topic.schema = "string data\n";
    topic.metadata["callerid"] = "/us";
    const uint32_t first = bag.add_topic(topic);
    topic.name = "/map";
    topic.is_latched = true;
    const uint32_t second = bag.add_topic(topic);
    for (int i = 0; i < count; ++i) {
      const Bytes bytes(bytes_each, static_cast<uint8_t>(i));
      const int64_t time_ns = int64_t{1'000'000'000} * (i ^ 1);
      bag.write(i % 3 == 0 ? second : first, time_ns, time_ns, bytes);
    }
    bag.finish();
    out.finish();
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "a.bag";
};

TEST_F(WrittenBag, ComesBackInTheOrderOfTime) {
  constexpr int kCount = 64;
  write(kCount, 50'000);  // several chunks
  const auto source = open_messages(path_);
  std::vector<int64_t> seconds;
  int latched = 0;
  while (const auto message = source->next()) {
    seconds.push_back((message->received_ns + 1) / 1'000'000'000);
    latched += message->topic->is_latched ? 1 : 0;
    ASSERT_EQ(message->bytes.size(), 50'000U);
    EXPECT_EQ(message->bytes.front(), static_cast<uint8_t>(seconds.back() ^ 1));
  }
  ASSERT_EQ(seconds.size(), std::size_t{kCount});
  for (int i = 0; i < kCount; ++i) EXPECT_EQ(seconds[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(latched, 22);
  EXPECT_TRUE(source->notes().empty());  // it has an index
  EXPECT_EQ(source->topics()[0]->messages, 42);
  EXPECT_EQ(source->topics()[0]->metadata.at("callerid"), "/us");
}

// rosbag's own file header takes 4096 bytes behind the magic; its first chunk is at byte 4117.
TEST_F(WrittenBag, BeginsWhereRosExpectsIt) {
  write(1, 10);
  std::ifstream file(path_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(bytes.substr(0, 13), "#ROSBAG V2.0\n");
  EXPECT_EQ(bytes.substr(4117 + 4 + 4, 4), "op=\x05");
  const std::size_t frame = bytes.find("\x04\x22\x4D\x18");
  EXPECT_EQ(bytes.substr(frame + 4, 2), "\x64\x60");  // independent blocks of 1 MiB, a checksum
}

TEST_F(WrittenBag, IsRefusedWhereItsStartCannotBeWrittenAgain) {
  const std::filesystem::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  files::OutputFile out(pipe);
  BagWriter bag(out);
  EXPECT_THROW(bag.finish(), std::runtime_error);
  close(reader);
}

}  // namespace
}  // namespace marco::ros
