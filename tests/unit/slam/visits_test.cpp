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

}  // namespace
}  // namespace marco::slam
