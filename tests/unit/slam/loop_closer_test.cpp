#include "slam/loop_closer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::slam {
namespace {

// Round and round a square of 40 m: the last key scan stands where the first one does, 800 m on.
std::vector<KeyScan> rounds() {
  std::vector<KeyScan> keys;
  for (int i = 0; i <= 800; ++i) {
    KeyScan key;
    const double angle_rad = 2.0 * std::numbers::pi * i / 40;
    key.world_from_robot = {6.0 * std::cos(angle_rad), 6.0 * std::sin(angle_rad), 0.0};
    key.path_m = i;
    key.points_in_robot = {Points2(2, 0), Points2(2, 0)};
    keys.push_back(std::move(key));
  }
  return keys;
}

// After 800 m of path the poses of two key scans could be off by metres, but not when loops lead
// from one to the other in a few: then what looks alike three metres along the hall is not meant.
TEST(LoopCloser, WhereLoopsLeadNearPosesAreNotOffByThePathDriven) {
  const LoopCloserOptions options;
  const LoopCloser closer(options, CorrelativeMatcher{}, SurfelMatcher{});
  const std::vector<KeyScan> keys = rounds();
  const double closed_path_m = 798.0;
  for (const LoopQuestion& question : closer.questions(keys, closed_path_m)) {
    const double path_m = keys.back().path_m - keys[static_cast<std::size_t>(question.from)].path_m;
    EXPECT_NEAR(question.shift_m,
                std::min(options.max_drift_m, 0.3 + 2.0 * 0.03 + (path_m - 2.0) * 0.005), 1e-9);
  }
  const auto near = closer.questions(keys, closed_path_m, std::vector<double>(keys.size(), 5.0));
  ASSERT_EQ(near.size(), 2U);
  // 2 m since the last loop and 3 m over it.
  for (const LoopQuestion& question : near) {
    EXPECT_NEAR(question.shift_m, 0.3 + 2.0 * 0.03 + 3.0 * 0.005, 1e-9);
  }
}

}  // namespace
}  // namespace marco::slam
