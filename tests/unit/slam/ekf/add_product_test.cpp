#include "slam/line_slam/ekf/add_product.hpp"

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

// 256 columns at a time, each number summed in order.
double sum_in_order(const Eigen::MatrixXd& a,
                    const Eigen::MatrixXd& b,
                    Eigen::Index i,
                    Eigen::Index j) {
  double total = 0.0;
  for (Eigen::Index first = 0; first < a.cols(); first += 256) {
    double sum = 0.0;
    for (Eigen::Index k = first; k < std::min<Eigen::Index>(a.cols(), first + 256); ++k) {
      sum += a(i, k) * b(j, k);
    }
    total += sum;
  }
  return total;
}

struct Sizes {
  Eigen::Index rows, columns, depth;
};

// To the last bit: that is what makes all machines, wide registers or not, draw one map.
TEST(AddProduct, IsTheSumInOrder) {
  std::mt19937 random(1);
  for (const Sizes& size :
       {Sizes{8, 4, 1}, {20, 3, 7}, {21, 9, 48}, {5, 17, 300}, {84, 84, 12}, {3, 2, 0}}) {
    const Eigen::MatrixXd a = random_matrix(size.rows, size.depth, random);
    const Eigen::MatrixXd b = random_matrix(size.columns, size.depth, random);
    for (const double sign : {1.0, -1.0}) {
      Eigen::MatrixXd c = Eigen::MatrixXd::Zero(size.rows, size.columns);
      add_product(sign, a, b, c);
      for (Eigen::Index i = 0; i < c.rows(); ++i) {
        for (Eigen::Index j = 0; j < c.cols(); ++j) {
          ASSERT_EQ(c(i, j), sign * sum_in_order(a, b, i, j)) << i << ", " << j;
        }
      }
    }
  }
}

TEST(AddProduct, AddsToPartsOfMatricesAndTouchesNothingElse) {
  std::mt19937 random(2);
  const Eigen::MatrixXd large = random_matrix(40, 40, random);
  Eigen::MatrixXd c = Eigen::MatrixXd::Ones(30, 30);
  add_product(1.0, large.block(3, 5, 11, 6), large.block(1, 20, 7, 6), c.block(4, 2, 11, 7));
  Eigen::MatrixXd expected = Eigen::MatrixXd::Ones(30, 30);
  expected.block(4, 2, 11, 7) += large.block(3, 5, 11, 6) * large.block(1, 20, 7, 6).transpose();
  EXPECT_LE((c - expected).cwiseAbs().maxCoeff(), 1e-14);  // six products of numbers below 1
}

TEST(AddProduct, SquaresAreRightBelowTheDiagonal) {
  std::mt19937 random(3);
  const Eigen::MatrixXd a = random_matrix(37, 12, random);
  Eigen::MatrixXd c = Eigen::MatrixXd::Identity(37, 37);
  add_square_to_lower(-1.0, a, c);
  for (Eigen::Index i = 0; i < 37; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      ASSERT_EQ(c(i, j), (i == j ? 1.0 : 0.0) - sum_in_order(a, a, i, j)) << i << ", " << j;
    }
  }
}

}  // namespace
}  // namespace marco::slam
