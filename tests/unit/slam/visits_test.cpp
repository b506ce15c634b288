#include "slam/map/visits.hpp"

#include <gtest/gtest.h>

#include "tests/support/two_rounds.hpp"

namespace marco::slam {
namespace {

struct Sum {
  int agreeing = 0;
  int contradicting = 0;
  double share() const { return static_cast<double>(contradicting) / (agreeing + contradicting); }
};

Sum sum_of(const std::vector<Keyframe>& keys) {
  Sum sum;
  for (const Visit& visit : find_visits(keys)) {
    sum.agreeing += visit.agreeing;
    sum.contradicting += visit.contradicting;
  }
  return sum;
}

TEST(Contradictions, TwoPassesOfARightMapAgree) {
  const testing::TwoRounds rounds;
  const Sum sum = sum_of(rounds.map.keys);
  EXPECT_GT(sum.agreeing, 1000);
  EXPECT_LT(sum.share(), 0.01);
}

TEST(Contradictions, ADoubledRoomContradicts) {
  const testing::TwoRounds rounds({0.8, 0.0, 0.1});
  EXPECT_GT(sum_of(rounds.map.keys).share(), 0.3);
}

TEST(Contradictions, ABoxThatWasMovedIsLittleOfTheRoom) {
  testing::FlatWorld moved = testing::small_room();
  moved.add_box(-3.2, -2.4, -2.6, -1.8);
  const testing::TwoRounds rounds({}, moved);
  const Sum sum = sum_of(rounds.map.keys);
  EXPECT_GT(sum.contradicting, 10);
  EXPECT_LT(sum.share(), 0.2);
}

// One pass over a place says nothing against itself.
TEST(Contradictions, OnlyAnotherPassIsCompared) {
  testing::TwoRounds rounds;
  rounds.map.keys.resize(20);  // 6 m of path
  EXPECT_TRUE(find_visits(rounds.map.keys).empty());
}

TEST(Contradictions, NamesThePointsThatStandInFreeSpace) {
  const testing::TwoRounds right, doubled({0.8, 0.0, 0.1});
  const std::vector<int> older{0, 1, 2}, newer{40, 41, 42};
  EXPECT_LT(points_in_free_space(right.map.keys, older, newer).cols(), 10);
  EXPECT_GT(points_in_free_space(doubled.map.keys, older, newer).cols(), 100);
}

TEST(Contradictions, EachIsComparedWithTheSamePlaceOfTheRoundBeforeAndCountsAsBothSaid) {
  const testing::TwoRounds rounds({0.03, 0.0, 0.01});
  const std::vector<Keyframe>& keys = rounds.map.keys;
  std::vector<int> met(keys.size(), 0);
  for (const Visit& visit : find_visits(keys)) {
    const Keyframe& older = keys[static_cast<std::size_t>(visit.older)];
    const Keyframe& newer = keys[static_cast<std::size_t>(visit.newer)];
    if (visit.older == visit.newer - testing::TwoRounds::kOfRound) {
      ++met[static_cast<std::size_t>(visit.newer)];
    }
    const Visit seen =
        compare(older, newer, between(older.world_from_robot, newer.world_from_robot));
    EXPECT_EQ(visit.agreeing, seen.agreeing);
    EXPECT_EQ(visit.contradicting, seen.contradicting);
    EXPECT_EQ(visit.seen(), visit.agreeing + visit.contradicting);
    EXPECT_LE(between(older.world_from_robot, newer.world_from_robot).translation_m().norm(), 3.0);
  }
  for (std::size_t key = 0; key < keys.size(); ++key) {
    EXPECT_EQ(met[key], key < testing::TwoRounds::kOfRound ? 0 : 1) << key;
  }
}

// A robot that passes one place every 10 m, each time a little farther off, and stops there for two
// keyframes.
TEST(Contradictions, APlaceIsComparedWithItsNearestVisitsEachOfThemOnce) {
  std::vector<Keyframe> keys;
  const testing::TwoRounds rounds;
  for (int pass = 0; pass < 8; ++pass) {
    for (const double ahead_m : {0.05, 0.0}) {
      keys.push_back(rounds.map.keys[0]);
      keys.back().world_from_robot = {ahead_m, 0.3 * pass, 0.0};
      keys.back().path_m = 12.0 * pass + 0.1 - ahead_m;  // in one stretch of path
    }
  }
  // Once it came back after 4 m already: these are two visits.
  keys[4].path_m += 4.0;
  std::vector<int> of_last, of_fourth;
  for (const Visit& visit : find_visits(keys)) {
    if (visit.newer == 15) of_last.push_back(visit.older);
    if (visit.newer == 7) of_fourth.push_back(visit.older);
  }
  EXPECT_EQ(of_last, (std::vector<int>{13, 11, 9, 7}));
  EXPECT_EQ(of_fourth, (std::vector<int>{5, 4, 3, 1}));
}

// In each direction, over the borders of whatever squares they are sorted into.
TEST(Contradictions, WhatLiesFartherThanThreeMetresIsAnotherPlaceInAnyDirection) {
  const testing::TwoRounds rounds;
  for (int way = 0; way < 12; ++way) {
    for (const double distance_m : {2.9, 3.1}) {
      std::vector<Keyframe> keys(2, rounds.map.keys[0]);
      const Eigen::Vector2d off = Pose2{0, 0, 0.5 * way} * Eigen::Vector2d(distance_m, 0.0);
      keys[0].world_from_robot = {0.1, 0.1, 0.0};
      keys[1].world_from_robot = {0.1 + off.x(), 0.1 + off.y(), 0.0};
      keys[1].path_m = keys[0].path_m + 20.0;
      EXPECT_EQ(find_visits(keys).size(), distance_m < 3.0 ? 1U : 0U) << way;
      keys[1].path_m = keys[0].path_m + 7.0;
      EXPECT_TRUE(find_visits(keys).empty()) << "it has not been away";
    }
  }
}

// A box that the newer visit sees, where the older one saw the floor: in the world, wherever both
// stood.
TEST(Contradictions, PointsInFreeSpaceLieWhereTheyAreInTheWorld) {
  testing::FlatWorld moved = testing::small_room();
  moved.add_box(2.8, 0.0, 3.2, 0.4);
  const testing::TwoRounds rounds({}, moved);
  const Points2 found = points_in_free_space(rounds.map.keys, {0, 38}, {40, 41});
  ASSERT_GT(found.cols(), 20);
  for (const auto& point : found.colwise()) {
    EXPECT_LT((point - Eigen::Vector2d(3.0, 0.2)).cwiseAbs().maxCoeff(), 0.26);
  }
}

}  // namespace
}  // namespace marco::slam
