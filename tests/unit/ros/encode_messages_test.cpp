// Marco's values as messages of ROS: byte for byte as another writer has them, and read back.
#include "recordings/ros/encode_messages.hpp"

#include <gmock/gmock.h>

#include "recordings/ros/wire_reader.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco::ros {
namespace {

using marco::testing::IsNear;
using marco::testing::RosWriter;

constexpr const char* kEncodings[] = {"ros1", "cdr"};
constexpr int64_t kStampNs = 12'500'000'000;

RosWriter writer(const std::string& encoding) {
  return RosWriter(encoding == "cdr" ? RosWriter::Form::cdr : RosWriter::Form::ros1);
}

TEST(EncodedPose, IsAsAnotherWriterHasIt) {
  for (const std::string encoding : kEncodings) {
    PoseMessage pose;
    pose.header = {kStampNs, "map"};
    pose.pose.translation() = Eigen::Vector3d(1.0, -2.0, 3.0);
    RosWriter expected = writer(encoding).header(12.5, "map");
    expected.numbers(std::vector<double>{1.0, -2.0, 3.0, 0.0, 0.0, 0.0, 1.0});
    EXPECT_EQ(encode(encoding, pose), expected.bytes()) << encoding;
  }
}

TEST(EncodedGrid, IsAsAnotherWriterHasIt) {
  GridMap map;
  map.origin_m = {-1.5, 2.5};
  map.resolution_m = 0.05;
  map.width_cells = 2;
  map.height_cells = 2;
  map.occupancy = {0, 100, 37, GridMap::kUnknown};
  for (const std::string encoding : kEncodings) {
    RosWriter expected = writer(encoding).header(12.5, "map");
    expected.number(int32_t{12}).number(uint32_t{500'000'000}).number(0.05F);
    expected.number(uint32_t{2}).number(uint32_t{2});
    expected.numbers(std::vector<double>{-1.5, 2.5, 0.0, 0.0, 0.0, 0.0, 1.0}).number(uint32_t{4});
    expected.numbers(std::vector<int8_t>{0, 100, 37, -1});
    EXPECT_EQ(encode(encoding, Header{kStampNs, "map"}, map), expected.bytes()) << encoding;
  }
}

TEST(EncodedPath, HoldsEachPoseWithItsStamp) {
  for (const std::string encoding : kEncodings) {
    RosWriter expected = writer(encoding).header(12.5, "map").number(uint32_t{1});
    // Inside a message CDR's header of four bytes does not come again.
    if (encoding == "ros1") expected.number(uint32_t{0});
    expected.number(int32_t{3}).number(uint32_t{250'000'000}).text("map");
    expected.numbers(std::vector<double>{4.0, 5.0, 0.0, 0.0, 0.0, 0.0, 1.0});
    const std::vector<PoseMessage> path{{{3'250'000'000, "map"}, lift({4.0, 5.0, 0.0})}};
    EXPECT_EQ(encode(encoding, Header{kStampNs, "map"}, path), expected.bytes()) << encoding;
  }
}

TEST(EncodedTransforms, AreReadBack) {
  TransformMessage transform;
  transform.header = {kStampNs, "map"};
  transform.child_frame_id = "odom";
  transform.parent_from_child = lift({0.5, 0.25, -2.0});
  for (const std::string encoding : kEncodings) {
    const auto bytes = encode(encoding, std::vector<TransformMessage>{transform, transform});
    Topic topic;
    topic.encoding = encoding;
    topic.type = "tf2_msgs/TFMessage";
    const auto back = decode_transforms({&topic, 0, 0, bytes});
    ASSERT_EQ(back.size(), 2U);
    EXPECT_EQ(back[1].header.stamp_ns, kStampNs);
    EXPECT_EQ(back[1].child_frame_id, "odom");
    EXPECT_THAT(flatten(back[1].parent_from_child), IsNear(Pose2{0.5, 0.25, -2.0}, 1e-12, 1e-12));
  }
}

}  // namespace
}  // namespace marco::ros
