#include "slam/back_end/loop_closer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

// Round and round a square of 40 m: the last keyframe stands where the first one does, 800 m on.
std::vector<Keyframe> rounds() {
  std::vector<Keyframe> keys;
  for (int i = 0; i <= 800; ++i) {
    Keyframe key;
    const double angle_rad = 2.0 * std::numbers::pi * i / 40;
    key.world_from_robot = {6.0 * std::cos(angle_rad), 6.0 * std::sin(angle_rad), 0.0};
    key.path_m = i;
    key.points_in_robot = {Points2(2, 0), Points2(2, 0)};
    keys.push_back(std::move(key));
  }
  return keys;
}

// After 800 m of path the poses of two keyframes could be off by metres, but not when loops lead
// from one to the other in a few: then what looks alike three metres along the hall is not meant.
TEST(LoopCloser, WhereLoopsLeadNearPosesAreNotOffByThePathDriven) {
  const LoopCloserOptions options;
  const LoopCloser closer(options, CorrelativeMatcher{}, SurfelMatcher{});
  const std::vector<Keyframe> keys = rounds();
  const double closed_path_m = 798.0;
  const auto by_path = closer.candidates(keys, closed_path_m);
  ASSERT_FALSE(by_path.empty());
  for (const LoopCandidate& candidate : by_path) {
    const double path_m =
        keys.back().path_m - keys[static_cast<std::size_t>(candidate.from)].path_m;
    EXPECT_NEAR(candidate.shift_m,
                std::min(options.max_drift_m, 0.3 + 2.0 * 0.03 + (path_m - 2.0) * 0.005), 1e-9);
  }
  const auto near = closer.candidates(keys, closed_path_m, std::vector<double>(keys.size(), 5.0));
  ASSERT_EQ(near.size(), 2U);
  // 2 m since the last loop and 3 m over it.
  for (const LoopCandidate& candidate : near) {
    EXPECT_NEAR(candidate.shift_m, 0.3 + 2.0 * 0.03 + 3.0 * 0.005, 1e-9);
  }
}

// Two bare walls tell nothing of the way along them: a loop there must neither move the robot along
// nor claim to know.
TEST(LoopCloser, AlongABareHallWhatIsBelievedStays) {
  testing::FlatWorld hall;
  hall.add_chain({{-60, -1.5}, {60, -1.5}});
  hall.add_chain({{-60, 1.5}, {60, 1.5}});
  std::mt19937 random(4);
  LoopCandidate candidate;
  candidate.from = 0;
  candidate.to = 1;
  candidate.world_from_newest = {0.6, 0.05, 0.01};
  candidate.place = orient(hall.hits({}, 0.01, &random), {0, 0}, {});
  candidate.seen = orient(hall.hits({}, 0.01, &random), {0, 0}, {});
  candidate.shift_m = 1.0;
  candidate.turn_rad = 0.1;
  LoopCloserOptions options;
  options.unlikely_penalty = 0.0;  // the search alone is drawn to where noise fits best
  const LoopCloser closer(options, CorrelativeMatcher(), SurfelMatcher());
  const std::optional<Loop> loop = closer.verify(candidate);
  ASSERT_TRUE(loop.has_value());
  EXPECT_NEAR(loop->from_from_to.x_m, 0.6, 0.05);
  EXPECT_NEAR(loop->from_from_to.y_m, 0.0, 0.01);
  EXPECT_NEAR(loop->from_from_to.theta_rad, 0.0, deg_to_rad(0.2));
  EXPECT_GT(1.0 / std::sqrt(loop->information(0, 0)), 0.3);
  EXPECT_LT(1.0 / std::sqrt(loop->information(1, 1)), 0.05);
}

// What a robot sees at `pose`, whose believed pose is off by `drift`, of a place seen from the
// origin.
LoopCandidate candidate_of(const testing::FlatWorld& place,
                           const testing::FlatWorld& seen,
                           const Pose2& pose,
                           const Pose2& drift) {
  std::mt19937 random(4);
  LoopCandidate candidate;
  candidate.from = 3;
  candidate.to = 40;
  candidate.world_from_newest = pose * drift;
  candidate.place = orient(place.hits({}, 0.01, &random), {0, 0}, {});
  candidate.seen = orient(seen.hits(pose, 0.01, &random), {0, 0}, {});
  candidate.shift_m = 3.0;
  candidate.turn_rad = 0.2;
  return candidate;
}

testing::FlatWorld hall_with_doors(double every_m) {
  testing::FlatWorld hall;
  hall.add_chain({{-30, -1.5}, {30, -1.5}});
  hall.add_chain({{-30, 1.5}, {30, 1.5}});
  for (double x_m = -5.0 * every_m; x_m < 5.5 * every_m; x_m += every_m) {
    hall.add_box(x_m + 0.7, 1.0, x_m + 1.0, 1.5);
  }
  return hall;
}

TEST(LoopCloser, APlaceSeenAgainIsFoundWhereItIs) {
  testing::FlatWorld room = testing::small_room();
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  const Pose2 pose{0.4, -0.2, 0.3};
  const auto loop = closer.verify(candidate_of(room, room, pose, {0.8, 0.5, 0.1}));
  ASSERT_TRUE(loop.has_value());
  EXPECT_EQ(loop->from, 3);
  EXPECT_EQ(loop->to, 40);
  EXPECT_LT((loop->from_from_to.translation_m() - pose.translation_m()).norm(), 0.03);
  EXPECT_NEAR(loop->from_from_to.theta_rad, pose.theta_rad, 0.02);
  EXPECT_NEAR(loop->shift_m, std::hypot(0.8, 0.5), 0.05);
}

TEST(LoopCloser, AnotherRoomIsRefused) {
  testing::FlatWorld other;
  other.add_chain({{-9, -0.8}, {3, -0.8}, {3, 7}, {1.5, 7}, {1.5, 0.9}, {-9, 0.9}});
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  EXPECT_FALSE(closer.verify(candidate_of(testing::small_room(), other, {}, {0.3, 0, 0})));
}

// Doors every 2 m look alike: the loop is the one that drift explains best.
TEST(LoopCloser, OfPlacesThatLookAlikeTheNearestIsBelieved) {
  const testing::FlatWorld hall = hall_with_doors(2.0);
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  for (const double drift_m : {-0.5, 0.5}) {
    const auto loop = closer.verify(candidate_of(hall, hall, {0.1, 0, 0}, {drift_m, 0, 0}));
    ASSERT_TRUE(loop.has_value());
    EXPECT_NEAR(loop->from_from_to.x_m, 0.1, 0.1);
  }
}

}  // namespace
}  // namespace marco::slam
