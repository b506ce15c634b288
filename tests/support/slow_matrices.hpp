#pragma once

#include <Eigen/Core>
#include <cmath>

// The few decompositions that oracles need, as everybody knows them, on matrices of any size: each
// of Eigen's, for each type it is used with, takes a compiler seconds.
namespace marco::testing {

inline Eigen::MatrixXd times(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd product(a.rows(), b.cols());
  product.noalias() = a * b;
  return product;
}

/// Gauss and Jordan, with pivots by columns.
inline Eigen::MatrixXd inverse(Eigen::MatrixXd a) {
  const Eigen::Index n = a.rows();
  Eigen::MatrixXd result = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      if (std::abs(a(i, k)) > std::abs(a(pivot, k))) pivot = i;
    }
    a.row(k).swap(a.row(pivot));
    result.row(k).swap(result.row(pivot));
    const double scale = 1.0 / a(k, k);
    a.row(k) *= scale;
    result.row(k) *= scale;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double factor = a(i, k);
      if (i == k || factor == 0.0) continue;
      a.row(i) -= factor * a.row(k);
      result.row(i) -= factor * result.row(k);
    }
  }
  return result;
}

/// Cholesky's lower root; holds a NaN exactly when the matrix is not positive (to rounding).
inline Eigen::MatrixXd cholesky(const Eigen::MatrixXd& a) {
  const Eigen::Index n = a.rows();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) {
      double rest = a(i, j);
      for (Eigen::Index k = 0; k < j; ++k) rest -= lower(i, k) * lower(j, k);
      lower(i, j) = i == j ? std::sqrt(rest) : rest / lower(j, j);
    }
  }
  return lower;
}

/// No eigenvalue is below `least` (to rounding).
inline bool eigenvalues_reach(Eigen::MatrixXd a, double least) {
  a.diagonal().array() -= least;
  return cholesky(a).allFinite();
}

inline double log_determinant(const Eigen::MatrixXd& positive) {
  return 2.0 * cholesky(positive).diagonal().array().log().sum();
}

/// x^T A^-1 x.
inline double distance2(const Eigen::VectorXd& x, const Eigen::MatrixXd& a) {
  return x.dot(Eigen::VectorXd(inverse(a).lazyProduct(x)));
}

}  // namespace marco::testing
