#include "slam/scan_preparation.hpp"

#include <cmath>

namespace marco::slam {

Pose2 Velocity2::after(double seconds) const {
  const double turn = yaw_rad_per_s * seconds;
  const double x = ahead_m_per_s * seconds, y = left_m_per_s * seconds;
  // sin(t)/t and (1 - cos(t))/t; their series near 0.
  const double a = std::abs(turn) < 1e-6 ? 1.0 : std::sin(turn) / turn;
  const double b = std::abs(turn) < 1e-6 ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
  return {a * x - b * y, b * x + a * y, normalize_angle(turn)};
}

Velocity2 velocity_of(const Pose2& moved, double seconds) {
  const Pose2 chord = Pose2{0, 0, -0.5 * moved.theta_rad} * moved;
  return {chord.x_m / seconds, chord.y_m / seconds, moved.theta_rad / seconds};
}

PreparedScan prepare_scan(const LaserScan& scan,
                          const SensorInfo& info,
                          const Pose3& robot_from_sensor,
                          const Velocity2& velocity) {
  PreparedScan prepared;
  prepared.utime = scan.utime;
  prepared.sensor_in_robot = robot_from_sensor.translation().head<2>();
  prepared.sensor_heading_rad =
      std::atan2(robot_from_sensor.linear()(1, 0), robot_from_sensor.linear()(0, 0));
  prepared.beams = static_cast<int>(scan.size());
  prepared.hits_in_robot.resize(2, prepared.beams);
  const double beam_period_s =
      prepared.beams > 1 ? info.scan_duration_s / (prepared.beams - 1) : 0.0;
  const Eigen::Matrix2d turn = robot_from_sensor.linear().topLeftCorner<2, 2>();
  Eigen::Index used = 0;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double range_m = static_cast<double>(scan.ranges_m[beam]);
    // Written so that NaN fails too.
    if (!(range_m > 0.0 && range_m >= info.range_min_m && range_m < info.range_max_m)) continue;
    const double bearing_rad = scan.bearing_rad(beam);
    const Eigen::Vector2d hit_in_sensor(range_m * std::cos(bearing_rad),
                                        range_m * std::sin(bearing_rad));
    const Eigen::Vector2d hit_in_robot = turn * hit_in_sensor + prepared.sensor_in_robot;
    const double time_s = scan.time_offsets_s.empty()
                              ? beam_period_s * static_cast<double>(beam)
                              : static_cast<double>(scan.time_offsets_s[beam]);
    prepared.hits_in_robot.col(used++) = velocity.after(time_s) * hit_in_robot;
  }
  prepared.hits_in_robot.conservativeResize(2, used);
  prepared.no_return = prepared.beams - static_cast<int>(used);
  return prepared;
}

}  // namespace marco::slam
