#pragma once

#include "slam/front_end/motion_guess.hpp"
#include "slam/front_end/odometry_errors.hpp"
#include "slam/front_end/pose_with_covariance.hpp"

namespace marco::slam {

/// The robot carried on by one more move, before its scan is matched. World axes.
struct CarriedPose {
  PoseWithCovariance drifted;  ///< its covariance: of the pose against the local map
  OdometryBias bias;
  Eigen::Matrix3d pose_with_bias = Eigen::Matrix3d::Zero();  ///< their covariance
  /// The drift since the newest keyframe alone.
  Eigen::Matrix3d since_keyframe = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d jitter = Eigen::Matrix3d::Zero();     ///< of this reading alone
  Eigen::Vector3d corrected = Eigen::Vector3d::Zero();  ///< by scans, since the newest keyframe
  double way_m = 0.0;                                   ///< since then, see motion_m()
  bool by_odometry = false;
  bool turned_by_odometry = false;  ///< all the way since then

  /// Before any move.
  static CarriedPose at(const PoseWithCovariance& estimate) {
    CarriedPose carried;
    carried.drifted = estimate;
    return carried;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v("drifted", drifted);
    v("bias", bias);
    v("pose_with_bias", pose_with_bias);
    v("since_keyframe", since_keyframe);
    v("jitter", jitter);
    v("corrected", corrected);
    v("way_m", way_m);
    v("by_odometry", by_odometry);
    v("turned_by_odometry", turned_by_odometry);
  }
};

/// What a scan says of a CarriedPose.
struct ScanCorrection {
  Pose2 world_from_robot;                                 ///< by match and prediction together
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the match alone, world axes
  double prior_weight = 1.0;  ///< that the prediction had, see PosePrior
  bool judges_jitter = true;
};

/// Where odometry carries the robot, as scans have corrected it: a Kalman filter whose state is the
/// error of odometry against the local map, and its bias. A keyframe draws the map again where the
/// robot is, and with as much of it goes the error. A reading's jitter stays outside the state: a
/// match that differs by it leaves the filter nearly where it is, so that odometry carries weight
/// over many scans that each know little. Predicted by velocity alone a scan has no jitter,
/// and the filter follows each match. Not thread-safe.
class DriftFilter {
 public:
  CarriedPose carried(const MotionGuess& guess) const;

  /// Follows a move that no scan corrects.
  void follow(const CarriedPose& carried) { state_ = carried; }
  /// Follows a move whose scan was matched; `noise` learns what the scan says of the odometry.
  void correct(const CarriedPose& carried, const ScanCorrection& scan, OdometryNoise& noise);
  /// The newest scan became a keyframe. @param of_before  see SurfelMap::add()
  void begin_at_keyframe(double of_before, OdometryNoise& noise);
  /// The map, and the robot with it, was moved from `before` to `now`.
  void move_with_map(const Pose2& before, const Pose2& now);

  const CarriedPose& state() const { return state_; }
  void restore(const CarriedPose& state) { state_ = state; }

 private:
  CarriedPose state_;
};

}  // namespace marco::slam
