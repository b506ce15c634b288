#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/input/deskew.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// How a robot may move. How well its odometry knows that, OdometryNoise learns.
struct MotionOptions {
  double gyro_sigma_deg_per_s = 0.3;
  /// Without odometry: how much the velocity may change.
  double acceleration_m_per_s2 = 1.5;
  double turn_acceleration_deg_per_s2 = 400.0;
  double max_speed_m_per_s = 3.0;  ///< of the robot: what claims more is not believed
  double max_turn_rate_deg_per_s = 400.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("gyro_sigma_deg_per_s", gyro_sigma_deg_per_s, kPositive,
               "Standard deviation of the gyroscope's rate.");
    v.advanced("acceleration_m_per_s2", acceleration_m_per_s2, kPositive,
               "Expected acceleration when there is no odometry. More for agile robots and "
               "hand-held lasers.");
    v.advanced("turn_acceleration_deg_per_s2", turn_acceleration_deg_per_s2, kPositive,
               "Expected angular acceleration when there is no odometry.");
    v("max_speed_m_per_s", max_speed_m_per_s, kPositive,
      "The robot's top speed. Faster steps are rejected.");
    v("max_turn_rate_deg_per_s", max_turn_rate_deg_per_s, kPositive,
      "The robot's top turn rate. Faster turns are rejected.");
  }
};

/// A move since the scan before, in the robot's frame there.
struct MotionGuess {
  enum class Source { odometry, velocity, nothing };

  Pose2 before_from_now;
  /// Covariances of (x, y, theta) in the frame before; position and heading are independent. Drift
  /// adds up from move to move; jitter is this reading's alone.
  Eigen::Matrix3d drift = Eigen::Matrix3d::Identity(), jitter = Eigen::Matrix3d::Zero();
  Source source = Source::nothing;
  bool turn_by_gyro = false;

  Eigen::Matrix3d covariance() const { return drift + jitter; }
};

/// The velocity of a robot that moved by `moved` in `dt_s`; nothing when the time is too short to
/// tell, or the velocity is above the limits: the stamp or the odometry is wrong then.
std::optional<Velocity2> believed_velocity(const Pose2& moved,
                                           double dt_s,
                                           const MotionOptions& options);

/// The floor under a guess by velocity: what a stamp's jitter does to it.
inline constexpr double kMoveSigmaM = 0.01, kMoveSigmaDeg = 0.5;

}  // namespace marco::slam
