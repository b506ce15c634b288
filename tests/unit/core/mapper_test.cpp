#include "core/mapper.hpp"

#include <gmock/gmock.h>

#include <random>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "slam/process/slam_adapter.hpp"

namespace marco {
namespace {

using ::testing::Contains;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Pair;

std::vector<Sample> recorded_samples() {
  std::vector<Sample> samples;
  const auto recording = open_recording("logs/sample.lcm");
  while (auto sample = recording->next()) samples.push_back(std::move(*sample));
  return samples;
}

void feed(const std::vector<Sample>& samples, Mapper& mapper) {
  for (const Sample& sample : samples) {
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { mapper.add(one); }) mapper.add(one);
        },
        sample);
  }
}

TEST(Mapper, MapsAsTheSlamProcessDoes) {
  const std::vector<Sample> samples = recorded_samples();
  Mapper mapper;
  feed(samples, mapper);
  mapper.finish();

  process::BatchBus bus;
  slam::SlamAdapter slam(bus, {});
  for (const Sample& sample : samples) {
    const EncodedMessage message = encode_sample(sample);
    bus.deliver(message.channel, message.bytes, message.utime);
  }
  slam.finish();

  const Trajectory path = mapper.path(), expected = slam.slam().trajectory();
  ASSERT_EQ(path.size(), expected.size());
  ASSERT_GT(path.size(), 200U);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(path[i].utime, expected[i].utime);
    EXPECT_EQ(path[i].world_from_robot.vector(), expected[i].world_from_robot.vector()) << i;
  }
  EXPECT_EQ(mapper.map().occupancy, slam.slam().grid().to_map().occupancy);
  EXPECT_EQ(mapper.verdict().verdict, slam::Verdict::good);
}

TEST(Mapper, GivesEachScanItsPoseOnce) {
  const std::vector<Sample> samples = recorded_samples();
  Mapper mapper;
  std::vector<PoseEstimate> poses;
  for (const Sample& sample : samples) {
    feed({sample}, mapper);
    while (const auto pose = mapper.next_pose()) poses.push_back(*pose);
  }
  mapper.finish();
  while (const auto pose = mapper.next_pose()) poses.push_back(*pose);
  const Trajectory path = mapper.path();
  ASSERT_EQ(poses.size(), path.size());
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_EQ(poses[i].utime, path[i].utime);
  EXPECT_EQ(poses.back().status, PoseEstimate::Status::matched);
}

TEST(Mapper, SaysWhatItIgnored) {
  Mapper mapper;
  LaserScan scan;
  scan.channel = "NOSE";
  scan.ranges_m.assign(100, 2.0F);
  scan.bearing_step_rad = 0.01;
  mapper.add(scan);
  mapper.finish();
  EXPECT_FALSE(mapper.next_pose());
  EXPECT_THAT(mapper.ignored(), Contains(Pair(HasSubstr("NOSE"), 1)));
}

TEST(Mapper, DoubtsAMapOfScansThatShowNothing) {
  Mapper mapper;
  mapper.add(SensorInfo());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> range_m(0.5F, 9.0F);
  for (int i = 0; i < 60; ++i) {
    LaserScan scan;
    scan.utime = Utime::from_seconds(0.1 * i);
    scan.bearing_step_rad = 0.02;
    for (int beam = 0; beam < 180; ++beam) scan.ranges_m.push_back(range_m(random));
    mapper.add(scan);
  }
  mapper.finish();
  EXPECT_EQ(mapper.path().size(), 60U);
  EXPECT_NE(mapper.verdict().verdict, slam::Verdict::good);
}

}  // namespace
}  // namespace marco
