#include "drivers/imu/gyro_bias.hpp"

#include "common/pose2.hpp"

namespace marco::drivers::imu {

void GyroBias::add(const Eigen::Vector3d& rates, Utime measured) {
  constexpr double kMostBias = deg_to_rad(5.0);
  if (still_count_ == 0 || (rates - still_first_).norm() > limit_rad_per_s_ ||
      rates.norm() > kMostBias) {
    still_first_ = rates;
    still_sum_ = rates;
    still_count_ = 1;
    still_since_ = measured;
    return;
  }
  still_sum_ += rates;
  ++still_count_;
  if ((measured - still_since_).seconds() < still_s_) return;
  bias_ = still_sum_ / still_count_;
  still_count_ = 0;
}

}  // namespace marco::drivers::imu
