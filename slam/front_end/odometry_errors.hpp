#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/pose2.hpp"

namespace marco::slam {

/// Layout of SlamState from which on it holds what is learned of odometry: that of maps saved as
/// version 13. Each later layout has a name of its own, next to the fields that it brought.
inline constexpr uint32_t kDriftLayout = 13;

/// What a scan says of one error of odometry: its mean, and the covariance that is left.
struct ErrorEstimate {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< (x, y, theta)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// How far a robot has moved as its odometry's drift counts it [m]: a turn by a radian counts as
/// half a metre.
double motion_m(const Pose2& way);

/// How odometry errs, in the robot's frame: its drift, the variance that each metre of motion adds
/// for good, and its jitter, the variance of each reading by itself (stamps, quantization, late
/// wheels). Both are learned while scans correct odometry, by one step of expectation maximization
/// for each correction, with exponential forgetting (Shumway & Stoffer 1982; what differs: the
/// filter's own estimates stand for the smoothed ones). A direction that scans leave open teaches
/// nothing: what is left of its covariance is what was assumed.
struct OdometryNoise {
  Eigen::Vector3d drift_per_m;  ///< ahead, to the left [m^2/m], heading [rad^2/m]
  double jitter_m2, jitter_rad2;
  /// Number of samples that today's values count as; what is assumed counts as a few.
  double drift_samples, jitter_samples;

  /// As is assumed of wheels before scans have shown more.
  OdometryNoise();

  /// Of a way, in the frame where it begins.
  Eigen::Matrix3d drift(const Pose2& way) const;
  Eigen::Matrix3d jitter() const;

  /// @param error  of the way between two keyframes, in the robot's frame
  /// @param turn_by_odometry  else a gyroscope measured the heading, and only it is judged
  void learn_drift(const ErrorEstimate& error, double way_m, bool turn_by_odometry);
  /// @param error  of one reading, along any axes
  void learn_jitter(const ErrorEstimate& error, bool turn_by_odometry);

  template <class Visitor>
  void visit(Visitor& v) {
    v("drift_per_m", drift_per_m);
    v("jitter_m2", jitter_m2);
    v("jitter_rad2", jitter_rad2);
    v("drift_samples", drift_samples);
    v("jitter_samples", jitter_samples);
  }
};

/// The lasting errors of odometry, which grow with the way and not with its root: the scale error
/// of its ways (wheels larger than configured: above 0), that of its turns (a narrower track), and
/// the turn that it misses on each metre [rad/m] (two wheels that differ). DriftFilter estimates
/// them on the way; a batch run measures the same three from a whole drive, as scales of wheels and
/// track.
struct OdometryBias {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< (ways, turns, turn on a metre)
  Eigen::Matrix3d covariance;

  /// As is assumed before scans have shown more.
  OdometryBias();

  /// @param turn_by_gyro  only the way is odometry's
  Pose2 corrected(const Pose2& step, bool turn_by_gyro) const;
  /// Derivative of the pose after a step by the bias, in the world. @param theta_rad  before the
  /// step
  static Eigen::Matrix3d derivative(const Pose2& step, double theta_rad, bool turn_by_gyro);
  /// Tyres, loads and floors change slowly: what was learned is forgotten on the way.
  void forget(double way_m);
  void add(const Eigen::Vector3d& correction);

  template <class Visitor>
  void visit(Visitor& v) {
    v("mean", mean);
    v("covariance", covariance);
  }
};

}  // namespace marco::slam
