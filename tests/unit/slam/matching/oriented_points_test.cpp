#include "slam/matching/oriented_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

TEST(Orient, NormalsOfAWallAreAcrossItAndTowardsTheSensor) {
  testing::FlatWorld world;
  world.add_chain({{2, -5}, {2, 5}});
  const Points2 hits = world.hits({0, 0, 0});
  const OrientedPoints oriented = orient(hits, {0, 0}, {});
  ASSERT_GT(hits.cols(), 200);
  for (Eigen::Index i = 0; i < hits.cols(); ++i) {
    ASSERT_TRUE(oriented.has_normal(i)) << i;
    EXPECT_NEAR(oriented.normals(0, i), -1.0, 1e-6);
  }
}

TEST(Orient, AStepInDepthIsNotBridged) {
  testing::FlatWorld world;
  world.add_chain({{2, 0}, {2, 3}});
  world.add_chain({{4, -4}, {4, 0.2}});
  const Points2 hits = world.hits({0, 0, 0});
  const OrientedPoints oriented = orient(hits, {0, 0}, {});
  for (Eigen::Index i = 0; i < hits.cols(); ++i) {
    if (!oriented.has_normal(i)) continue;
    EXPECT_NEAR(oriented.normals(0, i), -1.0, 1e-3);
  }
}

// Every other beam goes astray: the wall's points find their neighbours beyond it.
TEST(Orient, OutliersBetweenAWallsPointsAreSteppedOver) {
  Points2 points(2, 20);
  for (int i = 0; i < 20; ++i) {
    points.col(i) =
        i % 2 == 0 ? Eigen::Vector2d(2.0, 0.04 * (i - 10)) : Eigen::Vector2d(9.0 + i, i);
  }
  const OrientedPoints oriented = orient(points, {0, 0}, {});
  for (int i = 2; i < 18; i += 2) {
    EXPECT_NEAR(oriented.normals(0, i), -1.0, 1e-9) << i;
  }
}

TEST(Orient, ScatteredPointsHaveNoNormal) {
  Points2 points(2, 5);
  points << 1.0, 1.2, 1.0, 1.2, 1.0,  //
      0.0, 0.1, 0.2, 0.3, 0.4;
  const OrientedPoints oriented = orient(points, {0, 0}, {});
  for (Eigen::Index i = 0; i < 5; ++i) EXPECT_FALSE(oriented.has_normal(i));
  EXPECT_EQ(orient(Points2(2, 0), {0, 0}, {}).points.cols(), 0);
}

// At 5 cm of noise a neighbourhood of 25 cm says nothing of a wall's direction.
TEST(Orient, NormalsOfNoisyRangesComeFromMoreOfTheWall) {
  testing::FlatWorld world;
  world.add_chain({{2, -5}, {2, 5}});
  std::mt19937 random(5);
  const auto off_by_more_than_20_deg = [&](double range_sigma_m) {
    const OrientedPoints oriented =
        orient(world.hits({}, 0.05, &random), {0, 0}, {}, range_sigma_m);
    EXPECT_EQ(oriented.range_sigma_m, range_sigma_m);
    const Eigen::Index wrong =
        (oriented.normals.row(0).array() > -std::cos(deg_to_rad(20.0))).count();
    return static_cast<double>(wrong) / static_cast<double>(oriented.points.cols());
  };
  EXPECT_LT(off_by_more_than_20_deg(0.05), 0.1);
  EXPECT_GT(off_by_more_than_20_deg(0.0), 0.4);
}

}  // namespace
}  // namespace marco::slam
