#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/pose2.hpp"

namespace marco::slam {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct ZeroVelocityState {
  Eigen::Vector3d map_error = Eigen::Vector3d::Zero();
  Matrix6 covariance = Matrix6::Zero();  ///< of the pose and the map's error

  template <class Visitor>
  void visit(Visitor& v) {
    v("map_error", map_error);
    v("covariance", covariance);
  }
};

/// Zero velocity update: the pose of a robot that stands, from many scans. A Kalman filter over the
/// pose, which hardly changes, and the local map's own error at this place, which does not: all
/// matches err by it alike, and their mean must not pull the robot away from where it stopped. Not
/// thread-safe.
class ZeroVelocityUpdate {
 public:
  struct Correction {
    Eigen::Vector3d step;  ///< (x, y, theta) from the pose before, world frame
    Eigen::Matrix3d covariance;
  };

  /// @param covariance  of the pose at which it stopped
  explicit ZeroVelocityUpdate(const Eigen::Matrix3d& covariance);
  explicit ZeroVelocityUpdate(const ZeroVelocityState& state) : state_(state) {}

  /// @param innovation  a match, less the pose: (x, y, theta)
  /// @param covariance  the match's own
  /// @returns nothing when the match contradicts all before: the robot was moved.
  std::optional<Correction> update(const Eigen::Vector3d& innovation,
                                   const Eigen::Matrix3d& covariance);

  const ZeroVelocityState& state() const { return state_; }

 private:
  ZeroVelocityState state_;
};

}  // namespace marco::slam
