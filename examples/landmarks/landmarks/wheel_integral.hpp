#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/pose2.hpp"
#include "landmarks/landmark_slam_options.hpp"
#include "landmarks/sighting.hpp"

namespace marco::slam {

/// Constant errors that the filter estimates, in this order.
enum SetUp : int {
  speed_scale,  ///< true speed = (1 + this) * measured
  turn_scale,
  turn_bias,  ///< [rad/s], added to the turn rate
  sensor_x,   ///< of the sensor in the robot's frame [m]
  sensor_y,
  sensor_yaw,
};
inline constexpr int kSetUpSize = 6;
using SetUpVector = Eigen::Matrix<double, kSetUpSize, 1>;

/// The motion between two moments, with how it depends on what is not known exactly.
struct WheelMotion {
  Pose2 start_from_end;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), start frame
  Eigen::Matrix<double, 3, kSetUpSize> by_set_up = Eigen::Matrix<double, 3, kSetUpSize>::Zero();
  double seconds = 0.0;
  double effort_m = 0.0;  ///< metres that the wheels ran; noise is proportional to it
};

/// Sums wheel velocities. A sample's velocity is that of the interval that ends with it, as wheels
/// that count have it; after the last one it stays for half a second at most. Not thread-safe.
class WheelIntegral {
 public:
  /// @returns false where the sample is older than the one before, or not finite: it is left out
  bool add(const WheelVelocity& sample, const SetUpVector& set_up, const SightingNoise& noise);
  /// Carries on to `utime` by the last velocity.
  void carry_to(Utime utime, const SetUpVector& set_up, const SightingNoise& noise);

  const WheelMotion& motion() const { return motion_; }
  std::optional<Utime> utime() const { return utime_; }
  /// Starts again from here.
  void restart() { motion_ = {}; }

 private:
  void advance(double seconds,
               const Eigen::Vector2d& velocity,
               const SetUpVector& set_up,
               const SightingNoise& noise);

  WheelMotion motion_;
  std::optional<Utime> utime_;
  std::optional<WheelVelocity> last_;
};

}  // namespace marco::slam
