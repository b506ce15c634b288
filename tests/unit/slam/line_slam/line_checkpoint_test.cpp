#include <gtest/gtest.h>

#include "slam/process/line_checkpoint.hpp"

namespace marco::slam {
namespace {

TEST(LineCheckpoint, RefusesWhatIsCutOrDamaged) {
  LineCheckpoint checkpoint;
  checkpoint.utime = Utime::from_us(5);
  WallFilter::Stored& filter = checkpoint.mapper.lines.filter;
  filter.mean = filter.first_estimate = Eigen::VectorXd::Ones(7);
  filter.covariance = Eigen::MatrixXd::Identity(7, 7);
  filter.walls.resize(1);
  checkpoint.mapper.key_beams.resize(1);
  checkpoint.mapper.key_beams[0].beams.resize(2);
  checkpoint.mapper.key_beams[0].beams[1] = {{1.0, 2.0}, 3.0, true};
  const std::vector<uint8_t> good = encode_checkpoint(checkpoint);
  const LineCheckpoint back = decode_checkpoint(good);
  EXPECT_EQ(back.mapper.lines.filter.covariance, filter.covariance);
  EXPECT_EQ(back.mapper.key_beams[0].beams[1].hit_m, Eigen::Vector2d(1.0, 2.0));
  EXPECT_THROW(LineMapper(LineMapperOptions{}).restore(back.mapper), std::invalid_argument)
      << "beams without their keyframe";
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW(
        decode_checkpoint({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}),
        std::invalid_argument);
  }
  for (std::size_t at = 0; at < good.size(); at += 7) {
    std::vector<uint8_t> bad = good;
    bad[at] ^= 0x10U;
    EXPECT_THROW(decode_checkpoint(bad), std::invalid_argument) << at;
  }
}

TEST(LineCheckpoint, VersionEightIsLaidOutAsItEverWas) {
  LineCheckpoint checkpoint;
  checkpoint.utime = Utime::from_us(5);
  WallFilter::Stored& filter = checkpoint.mapper.lines.filter;
  filter.next_id = 3;
  filter.walls.resize(1);
  filter.walls[0].id = 2;
  filter.walls[0].times_seen = 7;
  filter.walls[0].start_seen = true;
  filter.walls[0].evidence = WallEvidence(WallEvidenceOptions{}, 0.35);
  filter.walls[0].evidence.set_extent(0.05, 0.4);
  filter.circles.next_id = 9;
  filter.circles.circles.resize(1);
  filter.circles.circles[0].id = 8;
  filter.circles.circles[0].from_inside = true;
  filter.circles.circles[0].arc = SeenArc(WallEvidenceOptions{}, 0.5, 1.5, 0.2);
  filter.circles.candidates.resize(1);
  filter.circles.candidates[0].mean = {1.0, 2.0, 0.125};
  filter.circles.candidates[0].times_seen = 2;
  filter.mean = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  filter.first_estimate = 2.0 * filter.mean;
  filter.covariance = filter.mean * filter.mean.transpose();
  const std::vector<uint8_t> bytes = encode_checkpoint(checkpoint);
  const LineCheckpoint back = decode_checkpoint(bytes);
  const CircleMap::Stored& circles = back.mapper.lines.filter.circles;
  EXPECT_EQ(circles.circles.at(0).arc.span_rad, 1.5);
  EXPECT_EQ(circles.candidates.at(0).mean.z(), 0.125);
  uint32_t hash = 2166136261U;  // FNV-1a
  for (const uint8_t byte : bytes) hash = (hash ^ byte) * 16777619U;
  EXPECT_EQ(hash, 2054275331U);
  EXPECT_EQ(bytes.size(), 2133U);
}

}  // namespace
}  // namespace marco::slam
