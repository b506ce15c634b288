#include "mapping3d/path_correction.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::IsNear;

TEST(PathCorrection, WhatWasSeenMovesWithTheKeyframeBeforeIt) {
  const auto at = [](int64_t us) { return Utime::from_us(us); };
  const std::map<Utime, Pose2> known = {
      {at(10), {0, 0, 0}}, {at(20), {1, 0, 0}}, {at(30), {2, 0, 0}}, {at(40), {3, 0, 0}}};
  // The keyframe of 20 stays, that of 40 turned left about itself; one of 35 was never heard of.
  const Trajectory keys = {{at(20), {1, 0, 0}}, {at(35), {9, 9, 9}}, {at(40), {3, 1, 0.5}}};
  const PathCorrection correction(keys, known);
  EXPECT_THAT(correction.corrected(at(10), {0, 0, 0}), IsNear(Pose2{0, 0, 0}, 1e-12, 1e-12));
  EXPECT_THAT(correction.corrected(at(39), {2.9, 0, 0}), IsNear(Pose2{2.9, 0, 0}, 1e-12, 1e-12));
  EXPECT_THAT(correction.corrected(at(40), {3, 0, 0}), IsNear(Pose2{3, 1, 0.5}, 1e-12, 1e-12));
  EXPECT_THAT(correction.corrected(at(50), {4, 0, 0}),
              IsNear(Pose2{3 + std::cos(0.5), 1 + std::sin(0.5), 0.5}, 1e-12, 1e-12));
  EXPECT_TRUE(correction.has_key(at(20)));
  EXPECT_FALSE(correction.has_key(at(35)));
}

}  // namespace
}  // namespace marco::mapping3d
