#include "common/median.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace marco {
namespace {

TEST(Median, IsTheMiddleOneInAnyOrder) {
  EXPECT_EQ(median(std::vector<double>{}), 0.0);
  EXPECT_EQ(median(std::vector{7}), 7);
  EXPECT_EQ(median(std::vector{5.0, -1.0, 2.0}), 2.0);
  EXPECT_EQ(median(std::vector{4, 1, 3, 2}), 3) << "the upper of both";
}

// The estimate's own standard deviation is 1.17 sigma / sqrt(20000) = 0.0025; five of them.
TEST(Median, TellsTheSpreadOfAGaussian) {
  std::mt19937 random(42);
  std::normal_distribution<double> noise(0.0, 0.3);
  std::vector<double> sizes(20000);
  for (double& size : sizes) size = std::abs(noise(random));
  EXPECT_NEAR(kSigmaOfMedian * median(std::move(sizes)), 0.3, 0.012);
  // And exactly: half of all lie within it.
  EXPECT_NEAR(std::erf(1.0 / kSigmaOfMedian / std::sqrt(2.0)), 0.5, 1e-5);
}

}  // namespace
}  // namespace marco
