#include <gtest/gtest.h>

#include "slam/process/line_checkpoint.hpp"

namespace marco::slam {
namespace {

TEST(LineCheckpoint, RefusesWhatIsCutOrDamaged) {
  LineCheckpoint checkpoint;
  checkpoint.utime = Utime::from_us(5);
  WallFilter::Stored& filter = checkpoint.mapper.slam.filter;
  filter.mean = filter.first_estimate = Eigen::VectorXd::Ones(7);
  filter.covariance = Eigen::MatrixXd::Identity(7, 7);
  filter.walls.resize(1);
  checkpoint.mapper.key_beams.resize(1);
  checkpoint.mapper.key_beams[0].beams.resize(2);
  checkpoint.mapper.key_beams[0].beams[1] = {{1.0, 2.0}, 3.0, true};
  const std::vector<uint8_t> good = encode_checkpoint(checkpoint);
  const LineCheckpoint back = decode_checkpoint(good);
  EXPECT_EQ(back.mapper.slam.filter.covariance, filter.covariance);
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

}  // namespace
}  // namespace marco::slam
