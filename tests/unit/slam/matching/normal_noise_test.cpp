#include "slam/matching/normal_noise.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::slam {
namespace {

// Unit vectors at these angles, each off by noise.
Points2 normals_at(const std::vector<double>& angles_deg, double sigma_rad) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, sigma_rad);
  Points2 normals(2, static_cast<Eigen::Index>(angles_deg.size()));
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    const double angle_rad = deg_to_rad(angles_deg[static_cast<std::size_t>(i)]) + noise(random);
    normals.col(i) << std::cos(angle_rad), std::sin(angle_rad);
  }
  return normals;
}

std::vector<double> walls(const std::vector<double>& normals_deg, int points) {
  std::vector<double> angles_deg;
  for (const double normal_deg : normals_deg) {
    angles_deg.insert(angles_deg.end(), static_cast<std::size_t>(points), normal_deg);
  }
  return angles_deg;
}

TEST(NormalNoise, ABareCorridorTellsNothingOfTheWayAlong) {
  // Walls at 30 degrees; noise of 0.05 alone would be worth 0.25 points.
  const Points2 normals = without_noise(normals_at(walls({30, 210}, 50), 0.05));
  const Eigen::Vector2d along(-0.5, std::sqrt(0.75));
  // What is left is the noise of the corridor's own direction, of all points together.
  EXPECT_LT((along.transpose() * normals).squaredNorm(), 0.01);
  EXPECT_LT((normals.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-12);
}

TEST(NormalNoise, ADoorFrameInACorridorStays) {
  std::vector<double> angles_deg = walls({90, 270}, 50);
  angles_deg.insert(angles_deg.end(), 4, 0.0);
  const Points2 before = normals_at(angles_deg, 0.05);
  const Points2 after = without_noise(before);
  EXPECT_EQ(after.rightCols<4>(), before.rightCols<4>());
}

// Of walls that stand at no right angle none is turned to the other's.
TEST(NormalNoise, ARoomStays) {
  const Points2 before = normals_at(walls({0, 80, 180, 260}, 25), 0.05);
  const Points2 after = without_noise(before);
  EXPECT_LT((after - before).colwise().norm().maxCoeff(), 0.002);
}

TEST(NormalNoise, NothingAndExactNormalsStay) {
  EXPECT_EQ(without_noise(Points2(2, 0)).cols(), 0);
  const Points2 exact = normals_at(walls({90, 270}, 5), 0.0);
  EXPECT_LT((without_noise(exact) - exact).norm(), 1e-12);
}

}  // namespace
}  // namespace marco::slam
