#include "slam/line_slam/ekf/sparse_rows.hpp"

#include <Eigen/Cholesky>
#include <limits>

namespace marco::slam {

SparseRows::Square inverse_root(const SparseRows::Square& s) {
  const Eigen::LLT<SparseRows::Square> root(0.5 * (s + s.transpose()));
  if (root.info() != Eigen::Success) {
    return SparseRows::Square::Constant(s.rows(), s.rows(),
                                        std::numeric_limits<double>::quiet_NaN());
  }
  return root.matrixL().solve(SparseRows::Square::Identity(s.rows(), s.rows()));
}

}  // namespace marco::slam
