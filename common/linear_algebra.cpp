#include "common/linear_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace marco {

SmallVector solve_symmetric(const SmallMatrix& a, const SmallVector& b) {
  return a.ldlt().solve(b);
}

SmallMatrix inverse_of(const SmallMatrix& a) {
  return a.ldlt().solve(SmallMatrix::Identity(a.rows(), a.cols()));
}

SmallMatrix nonnegative_part(const SmallMatrix& a) {
  const Eigen::SelfAdjointEigenSolver<SmallMatrix> solver(a);
  const SmallMatrix& vectors = solver.eigenvectors();
  return vectors * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}

std::pair<Eigen::Vector2d, Eigen::Matrix2d> eigenpairs_of(const Eigen::Matrix2d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

std::pair<Eigen::Vector3d, Eigen::Matrix3d> eigenpairs_of(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace marco
