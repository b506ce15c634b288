#include "slam/front_end/zero_velocity_update.hpp"

#include <Eigen/LU>

namespace marco::slam {
namespace {

// By how much a standing robot's place may wander from scan to scan: its floor and the walls do.
constexpr double kWanderSigmaM = 3e-5;
constexpr double kWanderSigmaDeg = 0.001;

// The local map's own error at one place.
constexpr double kMapSigmaM = 0.003;
constexpr double kMapSigmaDeg = 0.05;

// Squared deviations (of 3 degrees of freedom; 1 of 900 honest ones is beyond) from which on a
// match contradicts those before.
constexpr double kContradiction = 16.0;

Eigen::Vector3d variances(double sigma_m, double sigma_deg) {
  const double sigma_rad = deg_to_rad(sigma_deg);
  return {sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad};
}

}  // namespace

Standing::Standing(const Eigen::Matrix3d& covariance) {
  state_.covariance.topLeftCorner<3, 3>() = covariance;
  state_.covariance.bottomRightCorner<3, 3>() = variances(kMapSigmaM, kMapSigmaDeg).asDiagonal();
}

std::optional<Standing::Look> Standing::look(const Eigen::Vector3d& off,
                                             const Eigen::Matrix3d& covariance) {
  Matrix6& p = state_.covariance;
  p.diagonal().head<3>() += variances(kWanderSigmaM, kWanderSigmaDeg);
  const Eigen::Matrix<double, 6, 3> with_sum = p.leftCols<3>() + p.rightCols<3>();
  const Eigen::Matrix3d expected = with_sum.topRows<3>() + with_sum.bottomRows<3>() + covariance;
  const Eigen::Vector3d surprise = off - state_.map_error;
  const Eigen::Matrix3d information = expected.inverse();
  if (surprise.dot(information * surprise) > kContradiction) return std::nullopt;
  const Eigen::Matrix<double, 6, 3> gain = with_sum * information;
  p -= gain * with_sum.transpose();
  p = 0.5 * (p + p.transpose()).eval();
  state_.map_error += gain.bottomRows<3>() * surprise;
  return Look{gain.topRows<3>() * surprise, p.topLeftCorner<3, 3>()};
}

}  // namespace marco::slam
