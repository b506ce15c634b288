#include "slam/doctor/rematch.hpp"

#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/two_rounds.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::TwoRounds;

TEST(Rematch, FindsWhereADoubledRoomBelongs) {
  const TwoRounds rounds({0.7, -0.4, 0.12});
  const auto better = match_again(rounds.map.keys, 3, 43);
  ASSERT_TRUE(better.has_value());
  // The room's noise is 1 cm a beam; a match of some thousand beams is far better.
  EXPECT_THAT(better->older_from_newer,
              IsNear(between(TwoRounds::place(3), TwoRounds::place(43)), 0.02, 0.01));
  EXPECT_NEAR(better->turn_rad, -0.12, 0.01);
  EXPECT_GT(better->overlap, better->overlap_before + 0.3);
}

TEST(Rematch, WhatLiesRightIsLeftThere) {
  const TwoRounds rounds;
  EXPECT_FALSE(match_again(rounds.map.keys, 3, 43).has_value());
}

TEST(Rematch, WhatIsOffByMoreThanTheWindowIsNotFound) {
  const TwoRounds rounds({4.0, 3.0, 1.0});
  EXPECT_FALSE(match_again(rounds.map.keys, 3, 43).has_value());
}

}  // namespace
}  // namespace marco::slam
