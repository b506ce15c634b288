#pragma once

#include <Eigen/Core>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::imu {

/// Estimates a gyroscope's bias: the mean of the rates while the robot stands still.
class GyroBias {
 public:
  /// @param limit_rad_per_s  rates that differ by less count as standing.
  /// @param still_s          for that long.
  GyroBias(double limit_rad_per_s, double still_s)
      : limit_rad_per_s_(limit_rad_per_s), still_s_(still_s) {}

  void add(const Eigen::Vector3d& rates, Utime measured);
  /// The sensor was away: keeps the estimate.
  void restart() { still_count_ = 0; }
  const Eigen::Vector3d& rad_per_s() const { return bias_; }

 private:
  double limit_rad_per_s_;
  double still_s_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d still_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d still_first_ = Eigen::Vector3d::Zero();
  int still_count_ = 0;
  Utime still_since_;
};

}  // namespace marco::drivers::imu
