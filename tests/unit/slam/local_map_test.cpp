#include "slam/map/local_map.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace marco::slam {
namespace {

// A round column of 0.6 m each, and nothing else: the map knows a keyframe's column or it does not.
constexpr int kPoints = 60;

Keyframe column_at(const Pose2& place) {
  Keyframe key;
  key.world_from_robot = place;
  key.points_in_robot = {Points2(2, kPoints), Points2(2, kPoints)};
  for (int i = 0; i < kPoints; ++i) {
    const double bearing_rad = 2.0 * std::numbers::pi * i / kPoints;
    const Eigen::Vector2d out(std::cos(bearing_rad), std::sin(bearing_rad));
    key.points_in_robot.points.col(i) = 0.6 * out;
    key.points_in_robot.normals.col(i) = out;
  }
  return key;
}

Pose2 place_of(int key) { return {3.0 * key, 1.0, 0.0}; }

class LocalMapTest : public ::testing::Test {
 protected:
  void grow_to(int count) {
    for (int key = set_.ever(); key < count; ++key) {
      set_.keys.push_back(column_at(place_of(key)));
      map_.extend(set_);
    }
  }
  bool holds(const LocalMap& map, const Pose2& place) const {
    const SurfelMatch match =
        matcher_.match(map.surfels(), column_at({}).points_in_robot, place, nullptr);
    return match.status != SurfelMatch::Status::no_overlap && match.overlap > 0.9;
  }
  /// The keyframes whose columns the map holds, counted in all ever made.
  std::vector<int> held(const LocalMap& map) const {
    std::vector<int> found;
    for (int key = 0; key < set_.ever(); ++key) {
      if (holds(map, place_of(key))) found.push_back(key);
    }
    return found;
  }
  std::vector<int> held() const { return held(map_); }
  bool search_sees(const Pose2& place) {
    const LikelihoodPyramid& likelihood = map_.likelihood(set_);
    const Eigen::Vector2d cell =
        (place * Eigen::Vector2d(0.6, 0.0) - likelihood.origin_m()) / likelihood.resolution_m();
    return likelihood.at(0, static_cast<int>(cell.x()), static_cast<int>(cell.y())) > 100;
  }

  SurfelMatcher matcher_{{}};
  KeyframeSet set_;
  LocalMap map_{{3, 1}, {}, {}};
};

TEST_F(LocalMapTest, IsMadeOfTheLastKeyframesAndOfAFewBeforeThem) {
  EXPECT_TRUE(map_.empty());
  EXPECT_EQ(map_.centre_m(), Eigen::Vector2d(0, 0));
  const std::vector<std::vector<int>> of_count{{0},       {0, 1},       {0, 1, 2}, {0, 1, 2, 3},
                                               {2, 3, 4}, {2, 3, 4, 5}, {4, 5, 6}};
  for (std::size_t i = 0; i < of_count.size(); ++i) {
    grow_to(static_cast<int>(i) + 1);
    EXPECT_EQ(held(), of_count[i]) << i;
    EXPECT_FALSE(map_.empty());
  }
}

// What is matched against must not change because an old keyframe became one with another.
TEST_F(LocalMapTest, AKeyframeThatWasMergedCountsAmongThoseEverMade) {
  grow_to(6);
  set_.keys.erase(set_.keys.begin());
  set_.merged = 1;
  const Eigen::Vector2d centre_m = map_.centre_m();
  map_.rebuild(set_);
  EXPECT_EQ(map_.centre_m(), centre_m);
  EXPECT_EQ(held(), (std::vector<int>{2, 3, 4, 5}));
  grow_to(7);
  EXPECT_EQ(held(), (std::vector<int>{4, 5, 6}));
}

TEST_F(LocalMapTest, RebuiltItHoldsKeyframesWhereTheyLieNow) {
  grow_to(4);
  const Pose2 moved = set_.keys[2].world_from_robot * Pose2{0.0, 1.5, 0.0};
  set_.keys[2].world_from_robot = moved;
  map_.rebuild(set_);
  EXPECT_EQ(held(), (std::vector<int>{0, 1, 3}));
  EXPECT_TRUE(holds(map_, moved));
}

// Its cells lie as before then, and so do the surfels of what has not moved.
TEST_F(LocalMapTest, MadeAnewAtAnyTimeItHasTheSameCentre) {
  for (int count = 5; count <= 12; ++count) {
    grow_to(count);
    const Eigen::Vector2d centre_m = map_.centre_m();
    map_.rebuild(set_);
    EXPECT_EQ(map_.centre_m(), centre_m) << count;
  }
}

TEST_F(LocalMapTest, RestoredItIsAsItWas) {
  grow_to(6);
  LocalMap restored({3, 1}, {}, {});
  restored.restore(set_, map_.centre_m());
  EXPECT_EQ(restored.centre_m(), map_.centre_m());
  EXPECT_EQ(held(restored), held());
  // The next keyframe is the one at which it is made anew.
  set_.keys.push_back(column_at(place_of(6)));
  map_.extend(set_);
  restored.extend(set_);
  EXPECT_EQ(restored.centre_m(), map_.centre_m());
  EXPECT_EQ(held(restored), held());
  restored.restore({}, {0, 0});
  EXPECT_TRUE(restored.empty());
}

TEST_F(LocalMapTest, ItsSearchSeesTheLastKeyframesWhereTheyLieNow) {
  grow_to(4);
  EXPECT_FALSE(search_sees(place_of(0)));
  for (const int key : {1, 2, 3}) EXPECT_TRUE(search_sees(place_of(key))) << key;
  grow_to(5);
  EXPECT_TRUE(search_sees(place_of(4)));
  EXPECT_FALSE(search_sees(place_of(1)));
  const Pose2 moved = place_of(4) * Pose2{0.0, 1.5, 0.0};
  set_.keys[4].world_from_robot = moved;
  map_.rebuild(set_);
  EXPECT_TRUE(search_sees(moved));
  set_.keys[4].world_from_robot = place_of(4);
  map_.drop_likelihood();
  EXPECT_TRUE(search_sees(place_of(4)));
  set_.keys[4].world_from_robot = moved;
  map_.restore(set_, map_.centre_m());
  EXPECT_TRUE(search_sees(moved));
}

}  // namespace
}  // namespace marco::slam
