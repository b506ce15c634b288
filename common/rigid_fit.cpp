#include "common/rigid_fit.hpp"

#include <cmath>

namespace marco {

Pose2 rigid_fit(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to) {
  const Eigen::Vector2d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  double dot = 0.0, cross = 0.0;
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    const Eigen::Vector2d a = from.col(i) - from_mean, b = to.col(i) - to_mean;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
  }
  const Pose2 turn{0.0, 0.0, std::atan2(cross, dot)};
  const Eigen::Vector2d shift = to_mean - turn.rotation() * from_mean;
  return {shift.x(), shift.y(), turn.theta_rad};
}

Eigen::VectorXd distances_after_fit(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to) {
  const Pose2 to_from = rigid_fit(from, to);
  Eigen::VectorXd distances(from.cols());
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    distances[i] = (to_from * Eigen::Vector2d(from.col(i)) - to.col(i)).norm();
  }
  return distances;
}

}  // namespace marco
