#include "slam/back_end/graph/selected_inverse.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace marco::slam {
namespace {

TEST(SelectedInverse, IsTheDenseInverseWhereTheMatrixHasEntries) {
  // A chain with loops, as graphs are: diagonally dominant, so positive.
  constexpr int kSize = 40;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kSize, kSize);
  const auto tie = [&](int a, int b) { dense(a, b) = dense(b, a) = uniform(random); };
  for (int i = 0; i + 1 < kSize; ++i) tie(i, i + 1);
  for (const int loop : {3, 7, 12, 18}) tie(loop, 2 * loop + 3);
  tie(0, kSize - 1);
  dense.diagonal() = dense.cwiseAbs().rowwise().sum().array() + 0.5;
  const SparseSolver solver(Eigen::SparseMatrix<double>(dense.sparseView()));
  ASSERT_EQ(solver.info(), Eigen::Success);
  const SelectedInverse selected(solver);
  const Eigen::MatrixXd inverse = dense.inverse();
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      if (dense(row, column) == 0.0) continue;
      // A few hundred roundings of values near 1.
      EXPECT_NEAR(selected.at(row, column), inverse(row, column), 1e-12) << row << " " << column;
    }
  }
  EXPECT_THROW(selected.at(kSize, 0), std::out_of_range);
}

}  // namespace
}  // namespace marco::slam
