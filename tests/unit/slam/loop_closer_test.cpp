#include "slam/back_end/loop_closer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/loop_candidate.hpp"

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

// The bias of scan matching grows with the way that leads from one keyframe to the other, less
// where a loop was closed since.
TEST(LoopCloser, AWayThroughTheGraphLeavesABias) {
  const LoopCloser closer({}, CorrelativeMatcher{}, SurfelMatcher{});
  const std::vector<Keyframe> keys = rounds();
  const auto sigma_m = [&](double way_m, double closed_path_m) {
    const std::vector<RelativeUncertainty> known(
        keys.size(), {diagonal_covariance(0.2, deg_to_rad(2.0)), way_m});
    const auto candidates = closer.candidates(keys, known, closed_path_m);
    EXPECT_EQ(candidates.size(), 2U);
    return std::sqrt(candidates.front().covariance(0, 0));
  };
  EXPECT_NEAR(sigma_m(0.0, 0.0), std::hypot(0.2, 0.1), 1e-9);
  EXPECT_NEAR(sigma_m(50.0, 0.0), std::hypot(0.2, 0.1, 0.5), 1e-9);
  EXPECT_NEAR(sigma_m(50.0, 798.0), std::hypot(0.2, 0.1, 0.02 + 48.0 / 600.0), 1e-9);
}

// Keyframes farther off than the graph allows are no candidates, and none is asked for its
// uncertainty where nothing lies near.
TEST(LoopCloser, CandidatesLieWithinReachOfWhatIsKnown) {
  const LoopCloser closer({}, CorrelativeMatcher{}, SurfelMatcher{});
  std::vector<Keyframe> keys = rounds();
  EXPECT_TRUE(closer.may_have_candidates(keys));
  keys.back().world_from_robot.x_m += 5.0;
  const auto count = [&](double sigma_m) {
    const std::vector<RelativeUncertainty> known(keys.size(),
                                                 {diagonal_covariance(sigma_m, 0.01), 0.0});
    return closer.candidates(keys, known, 0.0).size();
  };
  EXPECT_EQ(count(0.1), 0U);
  EXPECT_EQ(count(1.0), 2U);
  keys.back().world_from_robot.x_m += 100.0;
  EXPECT_FALSE(closer.may_have_candidates(keys));
}

// One point a keyframe, a metre apart.
std::vector<Keyframe> row_of(int count) {
  std::vector<Keyframe> keys;
  for (int i = 0; i < count; ++i) {
    Keyframe key;
    key.world_from_robot = {1.0 * i, 0, 0};
    key.path_m = i;
    key.points_in_robot = {Points2::Zero(2, 1), Points2::Zero(2, 1)};
    keys.push_back(std::move(key));
  }
  // And back to the first one.
  keys.back().world_from_robot.x_m = 0.0;
  return keys;
}

// What is searched in a wide window must be as long, or it fits anywhere.
TEST(LoopCloser, AWiderSearchIsMadeWithALongerQuery) {
  const LoopCloser closer({}, CorrelativeMatcher{}, SurfelMatcher{});
  const std::vector<Keyframe> keys = row_of(41);
  const auto query_length = [&](double sigma_m) {
    std::vector<RelativeUncertainty> known(keys.size(), {diagonal_covariance(0.01, 0.01), 0.0});
    known.front().covariance = diagonal_covariance(sigma_m, 0.01);
    const auto candidates = closer.candidates(keys, known, 40.0);
    EXPECT_EQ(candidates.size(), 1U);
    return candidates.front().seen.points.cols();
  };
  EXPECT_EQ(query_length(0.1), 5) << "4 keyframes before the newest";
  EXPECT_EQ(query_length(2.0), 7);
  EXPECT_EQ(query_length(20.0), 9) << "no search is wider than 8 m";
}

// Scans were lost: what was seen before the gap would find its own place, and take the newest
// keyframe to where it is not.
TEST(LoopCloser, NoQueryReachesAcrossAGap) {
  const LoopCloser closer({}, CorrelativeMatcher{}, SurfelMatcher{});
  const std::vector<Keyframe> keys = row_of(41);
  std::vector<RelativeUncertainty> known(keys.size(), {diagonal_covariance(0.6, 0.1), 0.0});
  for (std::size_t i = 39; i < keys.size(); ++i) known[i].covariance = diagonal_covariance(0, 0);
  const auto candidates = closer.candidates(keys, known, 40.0);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates.front().seen.points.cols(), 2);
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
  candidate.covariance = diagonal_covariance(0.33, 0.033);
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

testing::FlatWorld hall_with_doors(double every_m) {
  testing::FlatWorld hall;
  hall.add_chain({{-30, -1.5}, {30, -1.5}});
  hall.add_chain({{-30, 1.5}, {30, 1.5}});
  for (double x_m = -5.0 * every_m; x_m < 5.5 * every_m; x_m += every_m) {
    hall.add_box(x_m + 0.7, 1.0, x_m + 1.0, 1.5);
  }
  return hall;
}

OrientedPoints seen_from_all_along(const testing::FlatWorld& hall) {
  std::mt19937 random(9);
  std::vector<Keyframe> keys;
  for (double x_m = -6.0; x_m <= 6.0; x_m += 1.0) {
    Keyframe key;
    key.world_from_robot = {x_m, 0, 0};
    key.points_in_robot = orient(hall.hits(key.world_from_robot, 0.01, &random), {0, 0}, {});
    keys.push_back(std::move(key));
  }
  return join_points(keys, 0, static_cast<int>(keys.size()) - 1, {});
}

TEST(LoopCloser, APlaceSeenAgainIsFoundWhereItIs) {
  testing::FlatWorld room = testing::small_room();
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  const Pose2 pose{0.4, -0.2, 0.3};
  const auto loop = closer.verify(testing::candidate_of(room, room, pose, {0.8, 0.5, 0.1}));
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
  EXPECT_FALSE(closer.verify(testing::candidate_of(testing::small_room(), other, {}, {0.3, 0, 0})));
}

// Doors every 2 m look alike: the loop is the one that drift explains best, where it can tell, and
// none where it cannot.
TEST(LoopCloser, OfPlacesThatLookAlikeTheOneIsBelievedThatHasNoRival) {
  const testing::FlatWorld hall = hall_with_doors(2.0);
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  for (const double drift_m : {-0.3, 0.3}) {
    const auto loop =
        closer.verify(testing::candidate_of(hall, hall, {0.1, 0, 0}, {drift_m, 0, 0}, 0.6));
    ASSERT_TRUE(loop.has_value());
    EXPECT_NEAR(loop->from_from_to.x_m, 0.1, 0.1);
  }
  LoopCandidate either = testing::candidate_of(hall, hall, {0.1, 0, 0}, {0.8, 0, 0}, 1.5);
  either.place = seen_from_all_along(hall);
  EXPECT_FALSE(closer.verify(either));
  either.covariance = diagonal_covariance(0.4, 0.067);
  EXPECT_TRUE(closer.verify(either));
}

TEST(LoopCloser, ARivalBesideTheBestPlaceIsOne) {
  const testing::FlatWorld hall = hall_with_doors(0.6);
  const LoopCloser closer({}, CorrelativeMatcher(), SurfelMatcher());
  LoopCandidate either = testing::candidate_of(hall, hall, {0.1, 0, 0}, {0.3, 0, 0}, 1.0);
  either.place = seen_from_all_along(hall);
  EXPECT_FALSE(closer.verify(either));
}

}  // namespace
}  // namespace marco::slam
