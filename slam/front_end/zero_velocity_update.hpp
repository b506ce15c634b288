#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/pose2.hpp"

namespace marco::slam {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What a Standing remembers.
struct StandingState {
  Eigen::Vector3d map_error = Eigen::Vector3d::Zero();
  Matrix6 covariance = Matrix6::Zero();  ///< of the pose and the map's error

  template <class Visitor>
  void visit(Visitor& v) {
    v("map_error", map_error);
    v("covariance", covariance);
  }
};

/// Where a robot is that stands, by many looks from one place: a Kalman filter over the pose, which
/// hardly changes, and the local map's own error at this place, which does not: all looks err by it
/// alike, and their mean must not pull the robot away from where it stopped. Not thread-safe.
class Standing {
 public:
  struct Look {
    Eigen::Vector3d step;  ///< (x, y, theta) from the pose before, world frame
    Eigen::Matrix3d covariance;
  };

  /// @param covariance  of the pose at which it stopped
  explicit Standing(const Eigen::Matrix3d& covariance);
  explicit Standing(const StandingState& state) : state_(state) {}

  /// @param off  a match, less the pose: (x, y, theta)
  /// @param covariance  the match's own
  /// @returns nothing when the match contradicts all before: the robot was moved.
  std::optional<Look> look(const Eigen::Vector3d& off, const Eigen::Matrix3d& covariance);

  const StandingState& state() const { return state_; }

 private:
  StandingState state_;
};

}  // namespace marco::slam
