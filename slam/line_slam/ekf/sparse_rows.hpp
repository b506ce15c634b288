#pragma once

#include <Eigen/Core>
#include <array>

namespace marco::slam {

/// Rows of the state in a block: x1 y1 x2 y2 of a wall, or x y theta of the robot and one unused.
inline constexpr Eigen::Index kBlockSize = 4;

/// Up to four rows of a Jacobian that is zero outside up to three blocks of the state,
/// with what was measured.
struct SparseRows {
  static constexpr int kMaxRows = 4;
  static constexpr int kMaxBlocks = 3;
  using Jacobian = Eigen::
      Matrix<double, Eigen::Dynamic, kBlockSize * kMaxBlocks, 0, kMaxRows, kBlockSize * kMaxBlocks>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxRows, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows>;

  int num_blocks = 0;
  std::array<int, kMaxBlocks> blocks{};  ///< of the state
  Jacobian jacobian;                     ///< columns 4k..4k+3 belong to blocks[k]
  Vector innovation;                     ///< measured minus predicted
  Square noise;                          ///< its covariance

  int rows() const { return static_cast<int>(jacobian.rows()); }
  void resize(int rows) {
    jacobian.setZero(rows, kBlockSize * kMaxBlocks);
    innovation.setZero(rows);
    noise.setZero(rows, rows);
  }
};

/// L^-1 of S = L L^T: a measurement's rows times it are independent, of unit noise. Not a number
/// where S is not positive.
SparseRows::Square inverse_root(const SparseRows::Square& s);

}  // namespace marco::slam
