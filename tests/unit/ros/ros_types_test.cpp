// The rarer types that a map can be made of or compared with.
#include <gmock/gmock.h>

#include <numbers>

#include "recordings/ros/ros_reader.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/ros_wire.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::MemorySource;
using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::RosWriter;
using ::testing::Contains;
using ::testing::HasSubstr;

class Types : public ::testing::TestWithParam<RosWriter::Form> {
 protected:
  void add(const std::string& topic,
           const std::string& type,
           double at_s,
           const RosWriter& message) {
    source_->add(topic, type, at_s, message.bytes(),
                 GetParam() == RosWriter::Form::cdr ? "cdr" : "ros1");
  }
  void add_scan(double at_s) {
    RosWriter out(GetParam());
    out.header(at_s, "laser").numbers(std::vector<float>{-1, 1, 0.5F, 0, 0, 0.1F, 10});
    out.number(uint32_t{5}).numbers(std::vector<float>(5, 3.0F)).number(uint32_t{0});
    add("/scan", "sensor_msgs/LaserScan", at_s, out);
  }
  Recorded recorded(const RosOptions& options = {}) {
    return read_all(*open_ros(std::move(source_), options));
  }
  std::unique_ptr<MemorySource> source_ = std::make_unique<MemorySource>();
};
INSTANTIATE_TEST_SUITE_P(Ros,
                         Types,
                         ::testing::Values(RosWriter::Form::ros1, RosWriter::Form::cdr));

TEST_P(Types, OfSeveralEchoesTheFirstIsTheRange) {
  for (const double at_s : {1.0, 1.1, 1.2}) {
    RosWriter out(GetParam());
    out.header(at_s, "laser").numbers(std::vector<float>{-0.5F, 0.5F, 0.5F, 0, 0, 0.1F, 10});
    out.number(uint32_t{3});
    out.number(uint32_t{2}).numbers(std::vector<float>{2.0F, 4.0F});
    out.number(uint32_t{0});
    out.number(uint32_t{1}).numbers(std::vector<float>{5.0F});
    add("/echoes", "sensor_msgs/MultiEchoLaserScan", at_s, out.number(uint32_t{0}));
  }
  const Recorded found = recorded();
  ASSERT_EQ(found.scans.size(), 3U);
  EXPECT_EQ(found.scans[0].ranges_m[0], 2.0F);
  EXPECT_FALSE(found.scans[0].ranges_m[1] > 0.0F);  // no echo
  EXPECT_EQ(found.scans[0].ranges_m[2], 5.0F);
}

TEST_P(Types, AFlatCloudIsAScan) {
  for (const double at_s : {1.0, 1.1, 1.2}) {
    RosWriter out(GetParam());
    out.header(at_s, "laser").numbers(std::vector<uint32_t>{1, 3, 3});
    for (const auto& [name, offset] :
         {std::pair("x", 0U), std::pair("y", 4U), std::pair("z", 8U)}) {
      out.text(name).number(offset).number(uint8_t{7}).number(uint32_t{1});
    }
    out.number(uint8_t{0}).numbers(std::vector<uint32_t>{12, 36, 36});
    for (const std::array<float, 3>& point :
         {std::array{2.0F, 0.0F, 0.0F}, std::array{0.0F, 3.0F, 0.0F},
          std::array{NAN, 0.0F, 0.0F}}) {
      for (const float value : point) {
        const auto* raw = reinterpret_cast<const uint8_t*>(&value);
        out.numbers(std::vector<uint8_t>(raw, raw + 4));
      }
    }
    add("/cloud", "sensor_msgs/PointCloud2", at_s, out.number(uint8_t{0}));
  }
  const Recorded found = recorded();
  ASSERT_EQ(found.scans.size(), 3U);
  ASSERT_EQ(found.scans[0].size(), 2U);
  EXPECT_NEAR(found.scans[0].bearing_rad(1), std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(found.scans[0].ranges_m[1], 3.0F, 1e-6F);
}

TEST_P(Types, APoseIsTruthWhereTheUserSaysSo) {
  for (const double at_s : {1.0, 1.1, 1.2}) {
    add_scan(at_s);
    RosWriter out(GetParam());
    out.header(at_s, "map").numbers(std::vector<double>{at_s, 2, 0, 0, 0, 0, 1});
    add("/mocap", "geometry_msgs/PoseStamped", at_s, out);
    RosWriter joints(GetParam());
    joints.header(at_s, "").number(uint32_t{0}).number(uint32_t{0}).number(uint32_t{0});
    add("/joint_states", "sensor_msgs/JointState", at_s, joints.number(uint32_t{0}));
  }
  RosOptions options;
  options.truth = "/mocap";
  const Recorded found = recorded(options);
  ASSERT_EQ(found.truth.size(), 3U);
  EXPECT_NEAR(found.truth[2].world_from_robot.x_m, 1.2, 1e-12);
  EXPECT_THAT(found.report.notes,
              Contains(HasSubstr("not used: /joint_states (sensor_msgs/JointState)")));
}

}  // namespace
}  // namespace marco::ros
