#include "slam/ekf/sparse_rows.hpp"

#include <cmath>

namespace marco::slam {

SparseRows::Square inverse_root(const SparseRows::Square& s) {
  const Eigen::Index n = s.rows();
  SparseRows::Square lower = SparseRows::Square::Zero(n, n), inverse = lower;
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) {
      double rest = 0.5 * (s(i, j) + s(j, i));
      for (Eigen::Index k = 0; k < j; ++k) rest -= lower(i, k) * lower(j, k);
      lower(i, j) = i == j ? std::sqrt(rest) : rest / lower(j, j);
    }
  }
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) {
      double rest = i == j ? 1.0 : 0.0;
      for (Eigen::Index k = j; k < i; ++k) rest -= lower(i, k) * inverse(k, j);
      inverse(i, j) = rest / lower(i, i);
    }
  }
  return inverse;
}

}  // namespace marco::slam
