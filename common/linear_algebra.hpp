#pragma once

#include <Eigen/Core>
#include <utility>

/// Dense solvers, compiled once: each costs seconds in a file that compiles it by itself.
namespace marco {

/// Up to eight rows and columns, on the stack.
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8>;

/// x of a x = b, and a's inverse. @param a  symmetric, definite
SmallVector solve_symmetric(const SmallMatrix& a, const SmallVector& b);
SmallMatrix inverse_of(const SmallMatrix& a);
/// A symmetric matrix with its negative eigenvalues taken for 0.
SmallMatrix nonnegative_part(const SmallMatrix& a);

/// Eigenvalues of a symmetric matrix, growing, and their vectors, a column each.
std::pair<Eigen::Vector2d, Eigen::Matrix2d> eigenpairs_of(const Eigen::Matrix2d& symmetric);
std::pair<Eigen::Vector3d, Eigen::Matrix3d> eigenpairs_of(const Eigen::Matrix3d& symmetric);

/// Sums of weighted least squares.
template <int N>
struct NormalEquations {
  using Vector = Eigen::Matrix<double, N, 1>;
  Eigen::Matrix<double, N, N> information = Eigen::Matrix<double, N, N>::Zero();
  Vector gradient = Vector::Zero();

  /// @param row  the residual's derivatives
  void add(const Vector& row, double residual, double weight) {
    information.noalias() += weight * row * row.transpose();
    gradient += weight * residual * row;
  }
  /// Of Gauss and Newton.
  Vector step() const { return -solve_symmetric(information, gradient); }
};

}  // namespace marco
