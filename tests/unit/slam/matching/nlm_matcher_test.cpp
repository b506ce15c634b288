#include "slam/matching/nlm_matcher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/matching_world.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::MatchingLaser;
using ::marco::testing::take_scan;

const Pose2 kHere{3.5, 3.0, 0.4};
const Pose2 kMove{0.3, 0.05, deg_to_rad(8.0)};

struct Pair {
  Points2 target, source;
};
Pair scans(double outlier_part, double noise_m = 0.01) {
  std::mt19937 random(5);
  MatchingLaser laser;
  laser.outlier_part = outlier_part;
  laser.noise_m = noise_m;
  const auto world = testing::matching_room();
  return {take_scan(world, kHere, laser, random).points_in_robot,
          take_scan(world, kHere * kMove, laser, random).points_in_robot};
}

TEST(NlmSystem, GradientAndHessianAreTheDerivativesOfTheError) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  std::vector<PointPair> pairs(20);
  for (PointPair& p : pairs) {
    p.source << uniform(random), uniform(random);
    p.target = p.source + 0.2 * Eigen::Vector2d(uniform(random), uniform(random));
  }
  const auto at = [](const Eigen::Vector3d& v) { return Pose2{v[1], v[2], v[0]}; };
  const Eigen::Vector3d centre(0.3, 0.1, -0.2);
  for (const char* name : {"lorentzian", "least_squares", "geman_mcclure"}) {
    const Estimator estimator{estimator_kind(name), 0.2};
    const NlmSystem system = nlm_system(pairs, at(centre), estimator);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = 1e-5 * Eigen::Vector3d::Unit(k);
      const NlmSystem above = nlm_system(pairs, at(centre + h), estimator);
      const NlmSystem below = nlm_system(pairs, at(centre - h), estimator);
      // Second-order differences: error h^2 times third derivatives of order 1e3 = 1e-7.
      EXPECT_NEAR(system.gradient[k], (above.error - below.error) / 2e-5, 1e-5) << name;
      EXPECT_LT((system.hessian.col(k) - (above.gradient - below.gradient) / 2e-5).norm(), 1e-4)
          << name;
    }
  }
}

TEST(NlmMatcher, FindsTheMoveBetweenTwoScans) {
  const Pair pair = scans(0.1);
  const auto result = NlmMatcher().match(NlmTarget(pair.target), pair.source, Pose2{});
  EXPECT_EQ(result.status, MatchStatus::converged);
  // 1 cm of noise over 300 beams: a few mm, and as much for partners across corners.
  EXPECT_THAT(result.target_from_source, IsNear(kMove, 0.01, deg_to_rad(0.3)));
  EXPECT_GT(result.overlap, 0.75);
  EXPECT_GT(result.iterations, 3);
  // Noise of 1 cm in both scans, and what outliers within a few sigma (5 cm) add.
  EXPECT_GT(result.rms_m, 0.01);
  EXPECT_LT(result.rms_m, 0.04);
}

TEST(NlmMatcher, LeastSquaresIsTheSameMachineAndFollowsOutliers) {
  NlmOptions options;
  options.estimator = "least_squares";
  const Pair clean = scans(0.0), dirty = scans(0.2);
  EXPECT_THAT(
      NlmMatcher(options).match(NlmTarget(clean.target), clean.source, kMove).target_from_source,
      IsNear(kMove, 0.05, deg_to_rad(1.0)));
  const auto lost = NlmMatcher(options).match(NlmTarget(dirty.target), dirty.source, Pose2{});
  const auto held = NlmMatcher().match(NlmTarget(dirty.target), dirty.source, Pose2{});
  EXPECT_THAT(lost.target_from_source, ::testing::Not(IsNear(kMove, 0.01, deg_to_rad(0.3))));
  EXPECT_THAT(held.target_from_source, IsNear(kMove, 0.01, deg_to_rad(0.3)));
}

TEST(NlmMatcher, CalculatedPointsBeatRawPoints) {
  const Pair pair = scans(0.0);
  NlmOptions raw;
  raw.calculated_points = false;
  const auto error_m = [&](const NlmOptions& options) {
    const auto found = NlmMatcher(options).match(NlmTarget(pair.target), pair.source, Pose2{});
    return between(kMove, found.target_from_source).translation_m().norm();
  };
  EXPECT_LT(error_m({}), error_m(raw));
}

TEST(NlmMatcher, TheWayBackAndAMovedFrameAndPermutedPointsGiveTheSame) {
  const Pair pair = scans(0.1);
  const NlmMatcher matcher;
  const auto there = matcher.match(NlmTarget(pair.target), pair.source, Pose2{});
  const auto back = matcher.match(NlmTarget(pair.source), pair.target, Pose2{});
  // Not the same sums (partners differ): two matches, each within 1 cm and 0.3 deg as above.
  EXPECT_THAT(back.target_from_source, IsNear(there.target_from_source.inverse(), 0.02, 0.01));

  const Pose2 far{500.0, -500.0, 2.0};
  const auto moved = matcher.match(NlmTarget(far * pair.target), pair.source, far);
  // E takes the errors along x and y apart, so it is not quite the same in turned axes.
  EXPECT_THAT(moved.target_from_source, IsNear(far * there.target_from_source, 0.01, 0.005));

  Eigen::PermutationMatrix<Eigen::Dynamic> order(pair.source.cols());
  order.setIdentity();
  std::mt19937 random(8);
  std::shuffle(order.indices().begin(), order.indices().end(), random);
  const Points2 mixed = pair.source * order;
  const auto shuffled = matcher.match(NlmTarget(pair.target), mixed, Pose2{});
  EXPECT_THAT(shuffled.target_from_source, IsNear(there.target_from_source, 1e-6, 1e-6));
}

TEST(NlmMatcher, SaysNoOverlapForTooFewPointsOrAnotherPlace) {
  const Pair pair = scans(0.0);
  const NlmTarget target(pair.target);
  const NlmMatcher matcher;
  for (const int n : {0, 1}) {
    EXPECT_EQ(matcher.match(target, pair.source.leftCols(n), kMove).status,
              MatchStatus::no_overlap);
    EXPECT_EQ(matcher.match(NlmTarget(pair.target.leftCols(n)), pair.source, kMove).status,
              MatchStatus::no_overlap);
  }
  const Pose2 elsewhere{100.0, 0.0, 0.0};
  const auto result = matcher.match(target, pair.source, elsewhere);
  EXPECT_EQ(result.status, MatchStatus::no_overlap);
  EXPECT_THAT(result.target_from_source, IsNear(elsewhere, 0.0, 0.0));
  EXPECT_TRUE(result.covariance.allFinite());
}

TEST(NlmMatcher, CovarianceGrowsAlongACorridor) {
  std::mt19937 random(2);
  MatchingLaser laser;
  laser.max_range_m = 10.0;
  const auto world = testing::matching_corridor();
  const Points2 target = take_scan(world, {}, laser, random).points_in_robot;
  const Points2 source = take_scan(world, {0.2, 0.0, 0.0}, laser, random).points_in_robot;
  const auto result = NlmMatcher().match(NlmTarget(target), source, Pose2{});
  ASSERT_NE(result.status, MatchStatus::no_overlap);
  EXPECT_TRUE(result.covariance.allFinite());
  EXPECT_GT(result.covariance(0, 0), 100.0 * result.covariance(1, 1));
  EXPECT_LT(std::sqrt(result.covariance(1, 1)), 0.005);
}

// Identical scans without noise: each point measures its position across its wall with `noise_m`.
TEST(NlmMatcher, CovarianceIsThatOfTheIndependentPointsAcrossEachWall) {
  testing::FlatWorld box;
  box.add_box(-4, -3, 4, 3);
  const Points2 hits = box.hits({0, 0, 0});
  const auto result = NlmMatcher().match(NlmTarget(hits), hits, Pose2{});
  double across_x = 0.0, across_y = 0.0;
  for (const auto& hit : hits.colwise()) {
    across_x += std::abs(std::abs(hit.x()) - 4.0) < 1e-3 ? 1.0 : 0.0;
    across_y += std::abs(std::abs(hit.y()) - 3.0) < 1e-3 ? 1.0 : 0.0;
  }
  const double noise_m = NlmOptions{}.noise_m;
  ASSERT_GT(std::min(across_x, across_y), 50.0);
  // Points at corners have no clear direction.
  EXPECT_NEAR(result.information(0, 0) * noise_m * noise_m, across_x, 0.1 * across_x);
  EXPECT_NEAR(result.information(1, 1) * noise_m * noise_m, across_y, 0.1 * across_y);
  EXPECT_NEAR(result.covariance(0, 0) * across_x, noise_m * noise_m, 0.2 * noise_m * noise_m);
}

TEST(NlmMatcher, LosingCorrespondencesIsNoImprovement) {
  NlmOptions options;
  options.max_pair_m = 0.3;
  const Pair pair = scans(0.1);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> offset(-0.25, 0.25);
  int found = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose2 start = kMove * Pose2{offset(random), offset(random), 1.2 * offset(random)};
    const auto result = NlmMatcher(options).match(NlmTarget(pair.target), pair.source, start);
    const Pose2 off = between(kMove, result.target_from_source);
    found += off.translation_m().norm() < 0.02 ? 1 : 0;
  }
  EXPECT_EQ(found, 60);
}

TEST(NlmMatcher, RefusesImpossibleOptions) {
  NlmOptions options;
  options.sigma_schedule_m = {};
  EXPECT_THROW(NlmMatcher{options}, std::invalid_argument);
  options.sigma_schedule_m = {-1.0};
  EXPECT_THROW(NlmMatcher{options}, std::invalid_argument);
}

}  // namespace
}  // namespace marco::slam
