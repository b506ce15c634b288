#include "slam/front_end/range_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

// A corridor whose long walls are seen at up to 80 degrees of incidence.
testing::FlatWorld corridor() {
  testing::FlatWorld corridor;
  corridor.add_box(-10, -1.5, 10, 2.0);
  return corridor;
}

TEST(RangeNoise, IsThatOfTheRangesWhateverTheirSizeAndIncidence) {
  std::mt19937 random(7);
  for (const double sigma_m : {0.005, 0.01, 0.03, 0.05}) {
    double sum = 0.0;
    for (int i = 0; i < 20; ++i) {
      const Pose2 pose{0.3 * i - 3.0, 0.1, 0.2 * i};
      const auto found = range_sigma_of(corridor().hits(pose, sigma_m, &random), {0, 0});
      ASSERT_TRUE(found.has_value());
      sum += *found;
    }
    EXPECT_NEAR(sum / 20, sigma_m, 0.1 * sigma_m);
  }
}

TEST(RangeNoise, OfExactRangesIsNone) {
  const auto found = range_sigma_of(corridor().hits({0.5, 0.2, 1.0}, 0.0, nullptr), {0, 0});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(*found, 1e-6);
}

TEST(RangeNoise, DoesNotCountClutter) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(0.5, 1.0);
  Points2 points = corridor().hits({}, 0.01, &random);
  for (Eigen::Index i = 0; i < points.cols(); i += 8) points.col(i) *= anywhere(random);
  const auto found = range_sigma_of(points, {0, 0});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(*found, 0.02);
}

TEST(RangeNoise, IsNotKnownOfAFewPoints) {
  EXPECT_FALSE(range_sigma_of(Points2::Random(2, 15), {0, 0}).has_value());
  EXPECT_EQ(RangeNoise{}.sigma_m(), 0.0);
}

TEST(RangeNoise, FollowsAChangeAndNotASingleScan) {
  std::mt19937 random(7);
  RangeNoise noise;
  for (int i = 0; i < 31; ++i) noise.add(corridor().hits({}, 0.01, &random), {0, 0});
  for (int i = 0; i < 5; ++i) noise.add(corridor().hits({}, 0.05, &random), {0, 0});
  EXPECT_NEAR(noise.sigma_m(), 0.01, 0.002);
  for (int i = 0; i < 20; ++i) noise.add(corridor().hits({}, 0.05, &random), {0, 0});
  EXPECT_NEAR(noise.sigma_m(), 0.05, 0.01);
}

}  // namespace
}  // namespace marco::slam
