#include "common/rigid_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace marco {
namespace {

Eigen::Matrix2Xd random_points(Eigen::Index count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  Eigen::Matrix2Xd points(2, count);
  for (double& value : points.reshaped()) value = place(random);
  return points;
}

TEST(RigidFit, IsThatOfEigenByASingularValueDecomposition) {
  std::mt19937 random(5);
  for (const Eigen::Index count : {2, 3, 40}) {
    const Eigen::Matrix2Xd from = random_points(count, random);
    const Eigen::Matrix2Xd to = random_points(count, random);
    const Eigen::Matrix3d slow = Eigen::umeyama(from, to, false);
    const Pose2 fast = rigid_fit(from, to);
    EXPECT_TRUE(fast.rotation().isApprox(slow.topLeftCorner<2, 2>(), 1e-9)) << count;
    EXPECT_TRUE(fast.translation_m().isApprox(slow.topRightCorner<2, 1>(), 1e-9)) << count;
  }
}

TEST(RigidFit, WhatIsOnlyMovedIsLaidOnItself) {
  std::mt19937 random(6);
  const Pose2 to_from{3.0, -2.0, 2.9};
  const Eigen::Matrix2Xd from = random_points(9, random);
  Eigen::Matrix2Xd to = from;
  for (Eigen::Index i = 0; i < 9; ++i) to.col(i) = to_from * Eigen::Vector2d(from.col(i));
  EXPECT_LT(distances_after_fit(from, to).maxCoeff(), 1e-12);
  to(0, 4) += 0.9;  // the eight others keep near
  const Eigen::VectorXd off_m = distances_after_fit(from, to);
  EXPECT_GT(off_m[4], 0.6);
  EXPECT_NEAR(off_m.sum(), 0.9 + 0.8, 0.3);
}

TEST(RigidFit, OnePairIsMovedOnly) {
  const Pose2 fit = rigid_fit(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(4.0, 6.0));
  EXPECT_DOUBLE_EQ(fit.x_m, 3.0);
  EXPECT_DOUBLE_EQ(fit.y_m, 4.0);
  EXPECT_DOUBLE_EQ(fit.theta_rad, 0.0);
}

}  // namespace
}  // namespace marco
