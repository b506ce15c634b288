#include "slam/matching/surfel_matcher.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

OrientedPoints oriented(const Points2& hits) { return orient(hits, {0, 0}, {}); }

SurfelPyramid map_of(const testing::FlatWorld& world,
                     const std::vector<Pose2>& poses,
                     const Pose2& map_from_world = {}) {
  SurfelPyramid map({}, (map_from_world * poses.front()).translation_m());
  for (const Pose2& pose : poses) map.add(oriented(world.hits(pose)), map_from_world * pose);
  return map;
}

TEST(SurfelMatcher, FindsThePoseFromNoisyStarts) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}, {0.3, 0, 0.2}});
  const SurfelMatcher matcher;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> offset(-0.25, 0.25);
  for (int i = 0; i < 50; ++i) {
    const Pose2 truth{0.2 + 0.3 * offset(random), 0.1, 0.1};
    const Pose2 start{truth.x_m + offset(random), truth.y_m + offset(random),
                      truth.theta_rad + 0.5 * offset(random)};
    const SurfelMatch match = matcher.match(map, oriented(room.hits(truth)), start, nullptr);
    EXPECT_EQ(match.status, SurfelMatch::Status::converged);
    // No noise: what is left is the cells' averaging at corners.
    EXPECT_THAT(match.map_from_robot, IsNear(truth, 0.003, 0.001)) << i;
    EXPECT_GT(match.overlap, 0.9);
  }
}

TEST(SurfelMatcher, FarFromTheOriginItIsAsExact) {
  const testing::FlatWorld room = testing::small_room();
  const Pose2 map_from_world{5000.0, -3000.0, 0.7};
  const SurfelPyramid map = map_of(room, {{0, 0, 0}}, map_from_world);
  const Pose2 truth = map_from_world * Pose2{0.1, 0.05, 0.05};
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(room.hits({0.1, 0.05, 0.05})), map_from_world, nullptr);
  EXPECT_THAT(match.map_from_robot, IsNear(truth, 0.003, 0.001));
}

TEST(SurfelMatcher, KnowsThatACorridorSaysNothingAlongItself) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-50, -1}, {50, -1}});
  corridor.add_chain({{-50, 1}, {50, 1}});
  const SurfelPyramid map = map_of(corridor, {{0, 0, 0}});
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(corridor.hits({0.1, 0.1, 0.02})), {0.1, 0, 0}, nullptr);
  EXPECT_NEAR(match.map_from_robot.y_m, 0.1, 0.003);
  EXPECT_GT(match.information(1, 1), 1000.0 * std::max(1e-9, match.information(0, 0)));
}

TEST(SurfelMatcher, APriorDecidesWhereTheScanIsSilent) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-50, -1}, {50, -1}});
  corridor.add_chain({{-50, 1}, {50, 1}});
  const SurfelPyramid map = map_of(corridor, {{0, 0, 0}});
  PosePrior prior;
  prior.map_from_robot = {0.4, 0.0, 0.0};
  prior.information = 100.0 * Eigen::Matrix3d::Identity();
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(corridor.hits({0.4, 0.1, 0.02})), {0.2, 0, 0}, &prior);
  EXPECT_NEAR(match.map_from_robot.x_m, 0.4, 0.01);
  EXPECT_NEAR(match.map_from_robot.y_m, 0.1, 0.005);
}

TEST(SurfelMatcher, OutliersDoNotMoveTheMatch) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  std::mt19937 random(9);
  std::uniform_real_distribution<double> shorten(0.2, 0.95);
  Points2 hits = room.hits({0.1, 0.05, 0.05});
  for (Eigen::Index i = 0; i < hits.cols(); i += 5) hits.col(i) *= shorten(random);
  const SurfelMatch match = SurfelMatcher().match(map, oriented(hits), {0, 0, 0}, nullptr);
  EXPECT_THAT(match.map_from_robot, IsNear(Pose2{0.1, 0.05, 0.05}, 0.01, 0.003));
}

TEST(SurfelMatcher, NothingToMatchIsSaidAndLeavesTheGuess) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  const SurfelMatcher matcher;
  const Pose2 guess{1, 2, 0.3};
  const SurfelMatch empty = matcher.match(map, oriented(Points2(2, 0)), guess, nullptr);
  EXPECT_EQ(empty.status, SurfelMatch::Status::no_overlap);
  EXPECT_THAT(empty.map_from_robot, IsNear(guess, 0, 0));
  const SurfelMatch far = matcher.match(map, oriented(room.hits({0, 0, 0})), {300, 0, 0}, nullptr);
  EXPECT_EQ(far.status, SurfelMatch::Status::no_overlap);
}

TEST(SurfelMatcher, RefusesAScheduleWithoutOneSigmaALevel) {
  SurfelMatcherOptions options;
  options.sigmas_m.pop_back();
  EXPECT_THROW(SurfelMatcher{options}, std::invalid_argument);
}

TEST(SurfelMap, TheTwoFacesOfAThinWallStayApart) {
  SurfelMap map({0, 0}, 5.0, 0.2);
  OrientedPoints faces{Points2(2, 2), Points2(2, 2)};
  faces.points << 1.05, 1.06, 0.5, 0.5;
  faces.normals << -1, 1, 0, 0;
  map.add(faces, Pose2{});
  EXPECT_EQ(map.size(), 2U);
  const Surfel* surfel = map.find({1.1F, 0.5F}, {1.0F, 0.0F});
  ASSERT_NE(surfel, nullptr);
  EXPECT_FLOAT_EQ(surfel->mean_m.x(), 1.06F);
  EXPECT_EQ(map.find({1.1F, 0.5F}, {0.0F, 1.0F}), nullptr);
}

}  // namespace
}  // namespace marco::slam
