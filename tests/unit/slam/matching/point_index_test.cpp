#include "slam/matching/point_index.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::slam {
namespace {

PointIndex::Neighbour brute_force(const Points2& points,
                                  const Eigen::Vector2d& query,
                                  double radius_m) {
  PointIndex::Neighbour best{-1, radius_m * radius_m};
  for (int i = 0; i < points.cols(); ++i) {
    const double squared = (points.col(i) - query).squaredNorm();
    if (squared < best.squared_m2 || (squared == best.squared_m2 && best.index < 0))
      best = {i, squared};
  }
  return best;
}

void expect_same_as_brute_force(const Points2& points, double spread_m, std::mt19937& random) {
  const PointIndex index(points);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector2d centre = points.col(k % points.cols());
    const Eigen::Vector2d query =
        centre + spread_m * Eigen::Vector2d(uniform(random), uniform(random));
    for (const double radius_m : {0.1, 1.0, 50.0}) {
      EXPECT_EQ(index.nearest(query, radius_m).index, brute_force(points, query, radius_m).index);
    }
  }
}

TEST(PointIndex, EqualsBruteForceOnClustersLinesTiesAndFarCoordinates) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-5.0, 5.0);
  std::normal_distribution<double> gauss;
  Points2 cloud(2, 400), line(2, 100), lattice(2, 49), few(2, 2), far_spread(2, 20);
  for (auto p : cloud.colwise()) p << uniform(random), 0.3 * gauss(random);
  for (int i = 0; i < 100; ++i) line.col(i) << 0.01 * i, 500.0;
  for (int i = 0; i < 49; ++i) lattice.col(i) << 500 + i % 7, -500 + i / 7;
  few << 0.0, 3.0, 0.0, 0.0;
  for (int i = 0; i < 20; ++i) far_spread.col(i) << 1e4 * gauss(random), 1e4 * gauss(random);
  for (const Points2& points : {cloud, line, few, far_spread}) {
    expect_same_as_brute_force(points, 3.0, random);
  }
  const PointIndex index(lattice);
  EXPECT_EQ(index.nearest({502.5, -499.5}, 2.0).index, 2);  // four at the same distance: the lowest
}

TEST(PointIndex, FindsNothingAmongNoPointsOrNotFiniteOnes) {
  EXPECT_FALSE(PointIndex(Points2(2, 0)).nearest({0.0, 0.0}, 10.0));
  Points2 points(2, 2);
  points << std::nan(""), 1.0, 0.0, 1.0;
  EXPECT_EQ(PointIndex(points).nearest({0.0, 0.0}, 10.0).index, 1);
  EXPECT_FALSE(PointIndex(points).nearest({0.0, 0.0}, 1.0));
  EXPECT_FALSE(PointIndex(points).nearest({1e300, 0.0}, 1.0));
  EXPECT_THROW(PointIndex(points, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace marco::slam
