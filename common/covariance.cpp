#include "common/covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace marco {
namespace {

using Eigen::Matrix3d;

// f of a symmetric matrix: of each eigenvalue, those below zero taken for zero.
template <class Function>
Matrix3d by_eigenvalues(const Matrix3d& matrix, const Function& f) {
  const Matrix3d symmetric = 0.5 * (matrix + matrix.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  const Eigen::Vector3d values =
      solver.eigenvalues().unaryExpr([&f](double value) { return f(std::max(0.0, value)); });
  const Matrix3d& vectors = solver.eigenvectors();
  const Matrix3d result = vectors * values.asDiagonal() * vectors.transpose();
  return 0.5 * (result + result.transpose());
}

}  // namespace

Matrix3d covariance_of(const Matrix3d& information) {
  constexpr double kFloor = 1e-6;  // 1000 m, or radians: see the header
  return by_eigenvalues(information, [](double value) { return 1.0 / (value + kFloor); });
}

Matrix3d information_of(const Matrix3d& covariance) {
  constexpr double kFloor = 1e-9;  // 0.03 mm, or mrad
  return by_eigenvalues(covariance, [](double value) { return 1.0 / (value + kFloor); });
}

Matrix3d with_noise(const Matrix3d& information, const Matrix3d& noise) {
  const Matrix3d root = noise.llt().matrixL();
  const Matrix3d whitened = root.transpose() * information * root;
  const Matrix3d softened =
      by_eigenvalues(whitened, [](double value) { return value / (1.0 + value); });
  const Matrix3d half = root.triangularView<Eigen::Lower>().transpose().solve(softened);
  const Matrix3d result = root.triangularView<Eigen::Lower>().transpose().solve(half.transpose());
  return 0.5 * (result + result.transpose());
}

Matrix3d semidefinite_part(const Matrix3d& matrix) {
  if (is_semidefinite(matrix)) return matrix;
  return by_eigenvalues(matrix, [](double value) { return value; });
}

bool is_semidefinite(const Matrix3d& matrix) {
  constexpr double kRounding = 1e-9;  // of the largest: sums of doubles
  if (!matrix.allFinite()) return false;
  const double largest = matrix.cwiseAbs().maxCoeff();
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > kRounding * largest) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0] >= -kRounding * solver.eigenvalues()[2];
}

double position_sigma_m(const Matrix3d& covariance) {
  const double half_trace = 0.5 * (covariance(0, 0) + covariance(1, 1));
  return std::sqrt(half_trace +
                   std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1)));
}

Eigen::Matrix3d diagonal_covariance(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

Eigen::Matrix3d rotated(const Eigen::Matrix3d& matrix, double a_from_b_rad) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0, 0, a_from_b_rad}.rotation();
  return turn * matrix * turn.transpose();
}

Eigen::Matrix3d carried_along(const Eigen::Matrix3d& covariance,
                              const Pose2& world_from_a,
                              const Pose2& world_from_b) {
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry(0, 2) = -(world_from_b.y_m - world_from_a.y_m);
  carry(1, 2) = world_from_b.x_m - world_from_a.x_m;
  return carry * covariance * carry.transpose();
}

Eigen::Matrix3d transformed(const Eigen::Matrix3d& covariance, const Pose2& a_from_b) {
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry.topLeftCorner<2, 2>() = a_from_b.rotation();
  carry(0, 2) = a_from_b.y_m;
  carry(1, 2) = -a_from_b.x_m;
  return carry * covariance * carry.transpose();
}

Eigen::Vector3d difference(const Pose2& pose, const Pose2& from) {
  return {pose.x_m - from.x_m, pose.y_m - from.y_m,
          normalize_angle(pose.theta_rad - from.theta_rad)};
}

double squared_mahalanobis_distance(const Eigen::Vector3d& error,
                                    const Eigen::Matrix3d& information) {
  return error.dot(information * error);
}

}  // namespace marco
