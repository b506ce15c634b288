#include "common/linear_algebra.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace marco {
namespace {

constexpr double kRounding = 1e-12;

Eigen::Matrix3d definite() {
  return (Eigen::Matrix3d() << 4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 5.0).finished();
}

TEST(LinearAlgebra, SolvesAndInverts) {
  const Eigen::Vector3d x(1.0, -2.0, 3.0);
  const Eigen::Vector3d found = solve_symmetric(definite(), definite() * x);
  EXPECT_LT((found - x).norm(), kRounding);
  const Eigen::Matrix3d inverse = inverse_of(definite());
  EXPECT_LT((inverse * definite() - Eigen::Matrix3d::Identity()).norm(), kRounding);
}

TEST(LinearAlgebra, EigenvaluesGrowAndHaveAColumnEach) {
  const auto [values, vectors] = eigenpairs_of(definite());
  EXPECT_LT(values[0], values[1]);
  EXPECT_LT(values[1], values[2]);
  EXPECT_LT((definite() * vectors - vectors * values.asDiagonal()).norm(), kRounding);
  const auto [two, axes] = eigenpairs_of(Eigen::Matrix2d(Eigen::Vector2d(9.0, 4.0).asDiagonal()));
  EXPECT_NEAR(two[0], 4.0, kRounding);
  EXPECT_NEAR(std::abs(axes(1, 0)), 1.0, kRounding);
}

TEST(LinearAlgebra, NegativeEigenvaluesAreTakenForZero) {
  Eigen::Matrix2d turned;  // 3 along (1, 1), -1 across
  turned << 1.0, 2.0, 2.0, 1.0;
  const Eigen::Matrix2d part = nonnegative_part(turned);
  EXPECT_LT((part - Eigen::Matrix2d::Constant(1.5)).norm(), kRounding);
  EXPECT_LT((Eigen::Matrix3d(nonnegative_part(definite())) - definite()).norm(), kRounding);
}

// y = 2 x + 1 and a point beside it that weighs nothing.
TEST(NormalEquations, StepFitsALineByTheWeightedPoints) {
  NormalEquations<2> sum;
  const Eigen::Vector2d at(0.5, 0.5);  // slope and offset before the step
  for (const double x : {-1.0, 0.0, 2.0, 3.0}) {
    const Eigen::Vector2d row(x, 1.0);
    sum.add(row, row.dot(at) - (2.0 * x + 1.0), 0.1 * (x + 2.0));
  }
  sum.add({1.0, 1.0}, 100.0, 0.0);
  EXPECT_LT((at + sum.step() - Eigen::Vector2d(2.0, 1.0)).norm(), kRounding);
}

}  // namespace
}  // namespace marco
