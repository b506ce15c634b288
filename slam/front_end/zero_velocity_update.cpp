#include "slam/front_end/zero_velocity_update.hpp"

#include "slam/front_end/match_gates.hpp"

namespace marco::slam {
namespace {

// By how much a standing robot's place may wander from scan to scan: its floor and the walls do.
constexpr double kWanderSigmaM = 3e-5;
constexpr double kWanderSigmaDeg = 0.001;

// The local map's own error at one place.
constexpr double kMapSigmaM = 0.003;
constexpr double kMapSigmaDeg = 0.05;

}  // namespace

ZeroVelocityUpdate::ZeroVelocityUpdate(const Eigen::Matrix3d& covariance) {
  state_.covariance.topLeftCorner<3, 3>() = covariance;
  state_.covariance.bottomRightCorner<3, 3>() =
      diagonal_covariance(kMapSigmaM, deg_to_rad(kMapSigmaDeg));
}

std::optional<ZeroVelocityUpdate::Correction> ZeroVelocityUpdate::update(
    const Eigen::Vector3d& innovation, const Eigen::Matrix3d& covariance) {
  Matrix6& p = state_.covariance;
  p.topLeftCorner<3, 3>() += diagonal_covariance(kWanderSigmaM, deg_to_rad(kWanderSigmaDeg));
  const Eigen::Matrix<double, 6, 3> with_sum = p.leftCols<3>() + p.rightCols<3>();
  const Eigen::Matrix3d expected = with_sum.topRows<3>() + with_sum.bottomRows<3>() + covariance;
  const Eigen::Vector3d unexplained = innovation - state_.map_error;
  const Eigen::Matrix3d information = information_of(expected);
  if (squared_mahalanobis_distance(unexplained, information) > match_gates::kContradiction)
    return std::nullopt;
  const Eigen::Matrix<double, 6, 3> gain = with_sum * information;
  p -= gain * with_sum.transpose();
  p = 0.5 * (p + p.transpose()).eval();
  state_.map_error += gain.bottomRows<3>() * unexplained;
  return Correction{gain.topRows<3>() * unexplained, p.topLeftCorner<3, 3>()};
}

}  // namespace marco::slam
