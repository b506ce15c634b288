#include "slam/matching/match_result.hpp"

#include <Eigen/Dense>

namespace marco::slam {

void set_uncertainty(const Eigen::Matrix3d& normal_matrix,
                     double variance_m2,
                     MatchResult& result) {
  // Indoor poses are always known this well.
  const Eigen::Vector3d floor(1.0 / 100.0, 1.0 / 100.0, 1.0 / 9.8696);
  result.information = 0.5 * (normal_matrix + normal_matrix.transpose()) / variance_m2;
  result.information.diagonal() += floor;
  result.covariance = result.information.inverse();
  result.covariance = 0.5 * (result.covariance + result.covariance.transpose()).eval();
}

}  // namespace marco::slam
