#include "recordings/no_return_range.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco {
namespace {

constexpr double kOtherwiseM = 80.0;

// A robot's scans between walls 1 to `farthest_m` away, one beam in `every` without a return.
double found(double farthest_m, int every, double code_m, double noise_m) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> wall(1.0F, static_cast<float>(farthest_m));
  std::normal_distribution<double> noise(0.0, 1.0);
  NoReturnRange range;
  for (int scan = 0; scan < 100; ++scan) {
    std::vector<float> ranges_m;
    for (int beam = 0; beam < 180; ++beam) {
      const bool returns = every == 0 || (scan + beam) % every != 0;
      ranges_m.push_back(returns ? wall(random)
                                 : static_cast<float>(code_m + noise_m * noise(random)));
    }
    range.add(ranges_m);
  }
  return range.range_m(kOtherwiseM);
}

TEST(NoReturnRange, IsThePileAtTheTop) {
  const double limit_m = found(40.0, 20, 81.83, 0.0);
  EXPECT_LT(limit_m, 81.83);
  EXPECT_GT(limit_m, 80.0);
}

TEST(NoReturnRange, MayBeNoisy) {
  for (const double noise_m : {0.001, 0.02, 0.05}) {
    const double limit_m = found(12.0, 3, 12.0, noise_m);
    EXPECT_LT(limit_m, 12.0 - 3.0 * noise_m) << noise_m;
    EXPECT_GT(limit_m, 11.5) << noise_m;
  }
}

TEST(NoReturnRange, ThereMayBeNone) {
  EXPECT_EQ(found(20.0, 0, 0.0, 0.0), kOtherwiseM);
  EXPECT_EQ(NoReturnRange().range_m(kOtherwiseM), kOtherwiseM);
}

}  // namespace
}  // namespace marco
