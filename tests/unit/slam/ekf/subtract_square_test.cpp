#include "slam/line_slam/ekf/subtract_square.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::slam {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = uniform(random);
  return matrix;
}

double sum_in_order(const Eigen::MatrixXd& u, Eigen::Index i, Eigen::Index j) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < u.cols(); ++k) sum += u(i, k) * u(j, k);
  return sum;
}

struct Sizes {
  Eigen::Index rows, depth;
};

// To the last bit: that is what makes all machines, wide registers or not, draw one map. The sums
// of a row and a column are the same ones, so that blocks on the diagonal stay symmetric.
TEST(SubtractSquare, IsTheSumInOrder) {
  std::mt19937 random(1);
  for (const Sizes& size : {Sizes{8, 1}, {20, 7}, {21, 48}, {4, 300}, {84, 12}, {3, 2}, {12, 0}}) {
    const Eigen::MatrixXd u = random_matrix(size.rows, size.depth, random);
    const Eigen::MatrixXd before = random_matrix(size.rows, size.rows, random);
    Eigen::MatrixXd p = before;
    subtract_square(u, p);
    for (Eigen::Index j = 0; j < size.rows; ++j) {
      for (Eigen::Index i = j / 4 * 4; i < size.rows; ++i) {
        ASSERT_EQ(p(i, j), before(i, j) - sum_in_order(u, i, j)) << i << ", " << j;
      }
    }
  }
}

TEST(SubtractSquare, LeavesTheRoomBesideItAlone) {
  std::mt19937 random(2);
  const Eigen::MatrixXd u = random_matrix(12, 6, random), before = random_matrix(30, 30, random);
  Eigen::MatrixXd p = before;
  subtract_square(u, p);
  EXPECT_EQ(p.rightCols(18), before.rightCols(18));
  EXPECT_EQ(p.bottomRows(18), before.bottomRows(18));
}

}  // namespace
}  // namespace marco::slam
