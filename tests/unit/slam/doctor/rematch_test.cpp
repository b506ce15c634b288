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

// Of keyframes 3 and 6.
Pose2 true_way() { return between(TwoRounds::place(3), TwoRounds::place(6)); }

TEST(LiesBetter, WhereTheMapIsRightAndTheOtherIsOff) {
  const auto& keys = TwoRounds().map.keys;
  EXPECT_TRUE(lies_better_than(keys, 3, 6, true_way() * Pose2{0.4, 0.0, 0.0}));
  EXPECT_TRUE(lies_better_than(keys, 3, 6, true_way() * Pose2{0.0, 0.0, deg_to_rad(20.0)}));
}

TEST(LiesBetter, NotWhereBothAgreeOrTheMapIsOff) {
  TwoRounds rounds;
  EXPECT_FALSE(lies_better_than(rounds.map.keys, 3, 6, true_way() * Pose2{0.03, 0.0, 0.01}));
  for (std::size_t key = 5; key < rounds.map.keys.size(); ++key) {
    Pose2& pose = rounds.map.keys[key].world_from_robot;
    pose = Pose2{0.4, 0.0, 0.0} * pose;
  }
  EXPECT_FALSE(lies_better_than(rounds.map.keys, 3, 6, true_way()));
}

// Along bare walls a scan lies as well anywhere.
TEST(LiesBetter, NotAlongACorridor) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-50.0, -1.0}, {50.0, -1.0}});
  corridor.add_chain({{50.0, 1.0}, {-50.0, 1.0}});
  std::mt19937 random(5);
  std::vector<Keyframe> keys(8);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].world_from_robot = {0.3 * static_cast<double>(i), 0.0, 0.0};
    keys[i].path_m = keys[i].world_from_robot.x_m;
    keys[i].points_in_robot =
        orient(corridor.hits(keys[i].world_from_robot, 0.01, &random), Eigen::Vector2d::Zero(), {});
  }
  EXPECT_FALSE(lies_better_than(keys, 3, 6, {0.5, 0.0, 0.0}));
  EXPECT_TRUE(lies_better_than(keys, 3, 6, {0.9, 0.0, deg_to_rad(20.0)}));
}

}  // namespace
}  // namespace marco::slam
