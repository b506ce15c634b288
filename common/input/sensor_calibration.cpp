#include "common/input/sensor_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "common/input/deskew.hpp"

namespace marco {

void BeamCalibration::correct(LaserScan& scan, double range_max_m) const {
  scan.first_bearing_rad *= bearing_scale;
  scan.bearing_step_rad *= bearing_scale;
  for (float& bearing_rad : scan.bearings_rad) bearing_rad *= static_cast<float>(bearing_scale);
  if (range_offset_m == 0.0) return;
  const float no_return_m = static_cast<float>(std::min(range_max_m, kFarthestReturnM));
  for (float& range_m : scan.ranges_m) {
    if (!(range_m > 0.0F && range_m < no_return_m)) continue;
    range_m = std::max(0.0F, range_m + static_cast<float>(range_offset_m));
  }
}

Pose2 ArcMotion::moved() const { return Velocity2{ahead_m, left_m, turn_rad}.after(1.0); }

ArcMotion ArcMotion::of(const Pose2& moved) {
  const double half = 0.5 * moved.theta_rad;
  // The arc is longer than its chord, which lies half a turn to its side.
  const double stretch = std::abs(half) < 1e-6 ? 1.0 : half / std::sin(half);
  const double c = std::cos(half), s = std::sin(half);
  return {stretch * (c * moved.x_m + s * moved.y_m), stretch * (c * moved.y_m - s * moved.x_m),
          moved.theta_rad};
}

ArcMotion ArcMotion::seen_at(const Pose2& body_from_frame) const {
  const Eigen::Vector2d velocity =
      Eigen::Vector2d(ahead_m, left_m) + turn_rad * turned_left(body_from_frame.translation_m());
  const Eigen::Vector2d seen = body_from_frame.rotation().transpose() * velocity;
  return {seen.x(), seen.y(), turn_rad};
}

ArcMotion OdometryCalibration::corrected(const ArcMotion& by_odometry) const {
  const ArcMotion counted = by_odometry.seen_at(robot_from_axle());
  const double ahead_m = forward_sign * counted.ahead_m;
  const double apart_m = 0.5 * kCountedTrackM * turn_sign * counted.turn_rad;
  const double left_m = left_scale * (ahead_m - apart_m);
  const double right_m = right_scale * (ahead_m + apart_m);
  const double mean_scale = 0.5 * (left_scale + right_scale);
  const ArcMotion axle{0.5 * (left_m + right_m), mean_scale * forward_sign * counted.left_m,
                       (right_m - left_m) / (track_scale * kCountedTrackM)};
  return axle.seen_at(robot_from_axle().inverse());
}

SensorInfo LaserCalibration::corrected(SensorInfo as_said) const {
  if (as_said.channel != channel || as_said.mount != SensorInfo::Mount::robot) return as_said;
  Pose3& pose = as_said.parent_from_sensor;
  pose = lift(Pose2{x_m, y_m, deg_to_rad(yaw_deg)} * flatten(pose).inverse()) * pose;
  if (upside_down != (pose.linear()(2, 2) < 0.0)) {
    pose.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  }
  return as_said;
}

ImuSample GyroCalibration::corrected(ImuSample sample) const {
  sample.utime = sample.utime - Duration::from_seconds(late_s);
  double& rate = sample.angular_velocity_rad_per_s.z();
  rate = scale * (rate - bias_rad_per_s);
  return sample;
}

OdometrySample OdometryCorrector::corrected(OdometrySample sample,
                                            const OdometryCalibration& calibration) {
  if (calibration == OdometryCalibration{}) return sample;
  const Pose2 counted = sample.odom_from_robot;
  if (started_) {
    const ArcMotion step = ArcMotion::of(between(counted_, counted));
    corrected_ = corrected_ * calibration.corrected(step).moved();
  } else {
    corrected_ = counted;
  }
  started_ = true;
  counted_ = counted;
  sample.odom_from_robot = corrected_;
  sample.utime = sample.utime - Duration::from_seconds(calibration.late_s);
  const ArcMotion velocity =
      calibration.corrected({sample.velocity_m_per_s, 0.0, sample.yaw_rate_rad_per_s});
  sample.velocity_m_per_s = velocity.ahead_m;
  sample.yaw_rate_rad_per_s = velocity.turn_rad;
  return sample;
}

}  // namespace marco
