#include "landmarks/wheel_integral.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kLongestHoldS =
    0.5;  // a speed counts on no longer: then the wheels' messages are missing
constexpr double kWheelArmM = 0.3;    // half a track: a turn on the spot runs the wheels, too
constexpr double kLeastMPerS = 0.01;  // creeping while the wheels count nothing
constexpr double kAcrossPart = 0.3;   // of the error along: wheels slip sideways less

}  // namespace

bool WheelIntegral::add(const WheelVelocity& sample,
                        const SetUpVector& set_up,
                        const SightingNoise& noise) {
  if (!std::isfinite(sample.speed_m_per_s) || !std::isfinite(sample.turn_rate_rad_per_s)) {
    return false;
  }
  if (last_ && sample.utime < last_->utime) return false;
  const Eigen::Vector2d now(sample.speed_m_per_s, sample.turn_rate_rad_per_s);
  if (utime_ && sample.utime > *utime_) {
    const double gap_s = (sample.utime - last_->utime).seconds();
    const double seconds = (sample.utime - *utime_).seconds();
    advance(gap_s > 2.0 * kLongestHoldS ? std::min(seconds, kLongestHoldS) : seconds, now, set_up,
            noise);
    utime_ = sample.utime;
  }
  if (!utime_) utime_ = sample.utime;
  last_ = sample;
  return true;
}

void WheelIntegral::carry_to(Utime utime, const SetUpVector& set_up, const SightingNoise& noise) {
  if (!last_ || utime <= *utime_) return;
  const Utime end = std::min(utime, last_->utime + Duration::from_seconds(kLongestHoldS));
  if (end > *utime_) {
    advance((end - *utime_).seconds(), {last_->speed_m_per_s, last_->turn_rate_rad_per_s}, set_up,
            noise);
  }
  utime_ = utime;
}

void WheelIntegral::advance(double seconds,
                            const Eigen::Vector2d& velocity,
                            const SetUpVector& set_up,
                            const SightingNoise& noise) {
  const double raw_m = velocity.x() * seconds, raw_rad = velocity.y() * seconds;
  const double way_m = raw_m * (1.0 + set_up[speed_scale]);
  const double turn_rad = raw_rad * (1.0 + set_up[turn_scale]) + seconds * set_up[turn_bias];
  const double half_rad = 0.5 * turn_rad;
  const double chord = std::abs(half_rad) < 1e-6 ? 1.0 : std::sin(half_rad) / half_rad;
  const Eigen::Vector2d along(std::cos(half_rad), std::sin(half_rad));
  const Eigen::Vector2d across = turned_left(along);
  const Pose2 step{way_m * chord * along.x(), way_m * chord * along.y(), turn_rad};

  Eigen::Matrix3d by_wheels;  // d step / d (along, across, turn)
  by_wheels << chord * along.x(), across.x(), 0.5 * way_m * across.x(),  //
      chord * along.y(), across.y(), 0.5 * way_m * across.y(),           //
      0.0, 0.0, 1.0;
  Eigen::Matrix<double, 3, kSetUpSize> wheels_by_set_up =
      Eigen::Matrix<double, 3, kSetUpSize>::Zero();
  wheels_by_set_up(0, speed_scale) = raw_m;
  wheels_by_set_up(2, turn_scale) = raw_rad;
  wheels_by_set_up(2, turn_bias) = seconds;

  const double effort_m = std::abs(raw_m) + kWheelArmM * std::abs(raw_rad) + kLeastMPerS * seconds;
  const double move2 = noise.move_sigma_m * noise.move_sigma_m * effort_m;
  const double turn2 = noise.turn_sigma_rad * noise.turn_sigma_rad * effort_m;
  const Eigen::Vector3d wheels(move2, kAcrossPart * kAcrossPart * move2, turn2);

  const double heading_rad = motion_.start_from_end.theta_rad;
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topLeftCorner<2, 2>() = motion_.start_from_end.rotation();
  Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
  const Eigen::Vector2d lever =
      Pose2{0, 0, heading_rad}.rotation() * turned_left(step.translation_m());
  carried.topRightCorner<2, 1>() = lever;
  const Eigen::Matrix3d by = turned * by_wheels;
  motion_.noise =
      carried * motion_.noise * carried.transpose() + by * wheels.asDiagonal() * by.transpose();
  motion_.by_set_up = carried * motion_.by_set_up + by * wheels_by_set_up;
  motion_.start_from_end = motion_.start_from_end * step;
  motion_.seconds += seconds;
  motion_.effort_m += effort_m;
}

}  // namespace marco::slam
