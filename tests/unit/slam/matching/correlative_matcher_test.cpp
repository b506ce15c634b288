#include "slam/matching/correlative_matcher.hpp"

#include <gtest/gtest.h>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

CorrelativeMatcherOptions coarse_options() {
  CorrelativeMatcherOptions options;
  options.resolution_m = 0.1;
  options.blur_m = 0.1;
  return options;
}

TEST(LikelihoodPyramid, PointsFarFromThePlaceAreLeftOutInTheirOrder) {
  Points2 points(2, 5);
  points << 1.0, 30.0, -2.0, 6.0, 6.1,  //
      2.0, 2.0, -7.0, -8.0, 2.0;
  const Points2 near = points_within(5.0, {1.0, -3.0}, points);
  ASSERT_EQ(near.cols(), 3);
  EXPECT_EQ(near.col(0), points.col(0));
  EXPECT_EQ(near.col(1), points.col(2));
  EXPECT_EQ(near.col(2), points.col(3));
}

TEST(LikelihoodPyramid, EachLevelHoldsTheLargestValueOfItsBlock) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 3.0);
  Points2 points(2, 20);
  for (Eigen::Index i = 0; i < 20; ++i) points.col(i) << uniform(random), uniform(random);
  const LikelihoodPyramid pyramid(points, coarse_options());
  for (int level = 1; level < pyramid.levels(); ++level) {
    const int block = 1 << level;
    for (int y = -block; y < 40; y += 3) {
      for (int x = -block; x < 40; x += 3) {
        int largest = 0;
        for (int dy = 0; dy < block; ++dy) {
          for (int dx = 0; dx < block; ++dx) {
            largest = std::max(largest, pyramid.at(0, x + dx, y + dy));
          }
        }
        ASSERT_EQ(pyramid.at(level, x, y), largest) << level << " " << x << " " << y;
      }
    }
  }
}

// Whether a pose of the lattice, seen from the window's centre, lies in the box left out.
bool is_excluded(const SearchWindow& window, const Eigen::Vector3d& off) {
  if (!window.excluded) return false;
  const Pose2& middle = window.excluded->map_from_robot;
  const Pose2& centre = window.map_from_robot_centre;
  constexpr double kRounding = 1e-6;
  return std::abs(off.x() - (middle.x_m - centre.x_m)) <=
             window.excluded->half_width_m + kRounding &&
         std::abs(off.y() - (middle.y_m - centre.y_m)) <=
             window.excluded->half_width_m + kRounding &&
         std::abs(off.z() - (middle.theta_rad - centre.theta_rad)) <=
             window.excluded->half_turn_rad + kRounding;
}

// The obvious way: every pose of the window's lattice.
double best_score_by_brute_force(const LikelihoodPyramid& map,
                                 const Points2& points,
                                 const SearchWindow& window,
                                 double resolution_m) {
  const double reach_m = std::max(1.0, std::min(10.0, points.colwise().norm().maxCoeff()));
  const double step_rad = resolution_m / reach_m;
  const int turns = static_cast<int>(std::ceil(window.half_turn_rad / step_rad));
  const int half = static_cast<int>(std::ceil(window.half_width_m / resolution_m));
  int best = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    Pose2 pose = window.map_from_robot_centre;
    pose.theta_rad += turn * step_rad;
    const Points2 cells = ((pose * points).colwise() - map.origin_m()) / map.resolution_m();
    for (int y = -half; y <= half; ++y) {
      for (int x = -half; x <= half; ++x) {
        if (is_excluded(window, {x * resolution_m, y * resolution_m, turn * step_rad})) continue;
        int sum = 0;
        for (Eigen::Index i = 0; i < cells.cols(); ++i) {
          sum += map.at(0, static_cast<int>(std::floor(cells(0, i))) + x,
                        static_cast<int>(std::floor(cells(1, i))) + y);
        }
        best = std::max(best, sum);
      }
    }
  }
  return best / (255.0 * static_cast<double>(points.cols()));
}

TEST(CorrelativeMatcher, FindsTheBestPoseOfItsLatticeAsBruteForceDoes) {
  const testing::FlatWorld room = testing::small_room();
  CorrelativeMatcherOptions options = coarse_options();
  options.max_points = 1000;
  const CorrelativeMatcher matcher(options);
  const LikelihoodPyramid map(room.hits({0, 0, 0}), options);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  for (int i = 0; i < 5; ++i) {
    const Pose2 truth{uniform(random), uniform(random), uniform(random)};
    Points2 few = room.hits(truth);
    for (Eigen::Index j = 0; j < 36; ++j) few.col(j) = few.col(10 * j).eval();
    few.conservativeResize(2, 36);
    const SearchWindow window{{0, 0, 0}, 0.5, 0.45};
    const CorrelativeMatch match = matcher.search(map, few, window, 0.0);
    EXPECT_DOUBLE_EQ(match.score,
                     best_score_by_brute_force(map, few, window, options.resolution_m));
  }
}

TEST(CorrelativeMatcher, FindsTheBestPoseOutsideWhatIsExcluded) {
  const testing::FlatWorld room = testing::small_room();
  CorrelativeMatcherOptions options = coarse_options();
  options.max_points = 1000;
  const CorrelativeMatcher matcher(options);
  const LikelihoodPyramid map(room.hits({0, 0, 0}), options);
  Points2 few = room.hits({0.3, -0.2, 0.2});
  for (Eigen::Index j = 0; j < 36; ++j) few.col(j) = few.col(10 * j).eval();
  few.conservativeResize(2, 36);
  SearchWindow window{{0, 0, 0}, 0.5, 0.45};
  const CorrelativeMatch best = matcher.search(map, few, window, 0.0);
  for (const double half_width_m : {0.12, 0.32}) {
    for (const double half_turn_rad : {0.06, 1.0}) {
      window.excluded = {best.map_from_robot, half_width_m, half_turn_rad};
      const CorrelativeMatch other = matcher.search(map, few, window, 0.0);
      EXPECT_LT(other.score, best.score);
      EXPECT_DOUBLE_EQ(other.score,
                       best_score_by_brute_force(map, few, window, options.resolution_m));
    }
  }
}

TEST(CorrelativeMatcher, OfPosesThatLookAlikeTheOneNearestToTheCentreIsFound) {
  // A corridor of equal doors, one a metre; the scan sees three of them.
  const auto doors = [](int count) {
    Points2 points(2, 20 * count);
    for (int i = 0; i < 20 * count; ++i) points.col(i) << 0.05 * i, i % 20 < 3 ? 0.2 : 0.0;
    return points;
  };
  const CorrelativeMatcher matcher;
  const LikelihoodPyramid map(doors(12), {});
  for (const double off_m : {-0.3, 0.0, 0.4}) {
    const SearchWindow window{{5.0 + off_m, 0.0, 0.0}, 3.0, 0.1, 0.25};
    const CorrelativeMatch match = matcher.search(map, doors(3), window, 0.3);
    // Half a cell; the score is the scan's alone.
    EXPECT_THAT(match.map_from_robot, IsNear(Pose2{5.0, 0.0, 0.0}, 0.051, 0.02)) << off_m;
    EXPECT_GT(match.score, 0.8);
  }
}

TEST(CorrelativeMatcher, WithAPenaltyFindsTheBestPoseOfItsLatticeAsWell) {
  const testing::FlatWorld room = testing::small_room();
  CorrelativeMatcherOptions options = coarse_options();
  options.max_points = 1000;
  const CorrelativeMatcher matcher(options);
  const LikelihoodPyramid map(room.hits({0, 0, 0}), options);
  Points2 few = room.hits({0.3, -0.2, 0.2});
  for (Eigen::Index j = 0; j < 36; ++j) few.col(j) = few.col(10 * j).eval();
  few.conservativeResize(2, 36);
  const SearchWindow all{{0, 0, 0}, 0.5, 0.45};
  const double unpenalized = matcher.search(map, few, all, 0.0).score;
  for (const double penalty : {0.05, 0.2, 0.6, 1.5}) {
    SearchWindow window = all;
    window.penalty_at_edge = penalty;
    const CorrelativeMatch match = matcher.search(map, few, window, 0.0);
    const double off_m = match.map_from_robot.translation_m().norm();
    const double off_turn = match.map_from_robot.theta_rad / 0.45;
    const double cost = penalty * (off_m * off_m / 0.25 + off_turn * off_turn);
    // Not worse than the pose found without, nor than the centre; 0.02: the turns' lattice ends
    // somewhat beyond the window.
    EXPECT_LE(match.score, unpenalized);
    EXPECT_GE(match.score - cost + 0.02 * penalty,
              unpenalized - penalty * (0.13 / 0.25 + std::pow(0.2 / 0.45, 2)));
    EXPECT_GE(match.score - cost + 0.02 * penalty,
              matcher.search(map, few, {{0, 0, 0}, 0.0, 0.0}, 0.0).score);
  }
}

TEST(CorrelativeMatcher, FindsAPoseFarFromTheGuess) {
  const testing::FlatWorld room = testing::small_room();
  const CorrelativeMatcher matcher;
  const LikelihoodPyramid map(room.hits({0, 0, 0}), {});
  const Pose2 truth{-1.0, 0.8, 0.6};
  const CorrelativeMatch match =
      matcher.search(map, room.hits(truth), {{0.3, -0.3, -0.2}, 1.6, 1.0}, 0.3);
  // Half a cell, and what the walls the first scan did not see take away.
  EXPECT_THAT(match.map_from_robot, IsNear(truth, 0.06, 0.02));
  EXPECT_GT(match.score, 0.5);
}

TEST(CorrelativeMatcher, NothingAboveTheScoreIsNothingFound) {
  const testing::FlatWorld room = testing::small_room();
  const CorrelativeMatcher matcher;
  const LikelihoodPyramid map(room.hits({0, 0, 0}), {});
  EXPECT_EQ(matcher.search(map, room.hits({0, 0, 0}), {{50, 50, 0}, 0.5, 0.1}, 0.3).score, 0.0);
  EXPECT_EQ(matcher.search(map, Points2(2, 0), {}, 0.3).score, 0.0);
  const LikelihoodPyramid nothing(Points2(2, 0), {});
  EXPECT_EQ(matcher.search(nothing, room.hits({0, 0, 0}), {}, 0.3).score, 0.0);
}

}  // namespace
}  // namespace marco::slam
