#include "common/input/deskew.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco {

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

namespace {

// The directions of beams, one after another. Equal steps are rotated: a sine and a cosine per beam
// would take longer than its match.
class Directions {
 public:
  explicit Directions(const LaserScan& scan)
      : scan_(scan), step_(std::cos(scan.bearing_step_rad), std::sin(scan.bearing_step_rad)) {}

  // To be called for each beam in turn.
  Eigen::Vector2d of(std::size_t beam) {
    constexpr std::size_t kRestart = 64;  // rounding adds up to 1e-14 over these
    if (!scan_.bearings_rad.empty() || beam % kRestart == 0) {
      const double bearing_rad = scan_.bearing_rad(beam);
      now_ = {std::cos(bearing_rad), std::sin(bearing_rad)};
    } else {
      now_ = {now_.x() * step_.x() - now_.y() * step_.y(),
              now_.x() * step_.y() + now_.y() * step_.x()};
    }
    return now_;
  }

 private:
  const LaserScan& scan_;
  Eigen::Vector2d step_, now_ = Eigen::Vector2d::Zero();
};

}  // namespace

DeskewedScan deskew_and_project(const LaserScan& scan,
                                const SensorInfo& info,
                                const Pose3& robot_from_sensor,
                                const Velocity2& velocity) {
  DeskewedScan deskewed;
  deskewed.utime = scan.utime;
  deskewed.sensor_in_robot = robot_from_sensor.translation().head<2>();
  deskewed.sensor_heading_rad =
      std::atan2(robot_from_sensor.linear()(1, 0), robot_from_sensor.linear()(0, 0));
  deskewed.beams = static_cast<int>(scan.size());
  deskewed.hits_in_robot.resize(2, deskewed.beams);
  deskewed.velocity = velocity;
  deskewed.beam_of_hit.reserve(scan.size());
  deskewed.time_of_hit_s.reserve(scan.size());
  const double beam_period_s =
      deskewed.beams > 1 ? info.scan_duration_s / (deskewed.beams - 1) : 0.0;
  const Eigen::Matrix2d turn = robot_from_sensor.linear().topLeftCorner<2, 2>();
  const double range_max_m = std::min(info.range_max_m, kFarthestReturnM);
  Directions directions(scan);
  Eigen::Index used = 0;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const Eigen::Vector2d direction = directions.of(beam);
    const double range_m = static_cast<double>(scan.ranges_m[beam]);
    // Written so that NaN fails too.
    if (!(range_m > 0.0 && range_m >= info.range_min_m && range_m < range_max_m)) continue;
    const Eigen::Vector2d hit_in_robot = turn * (range_m * direction) + deskewed.sensor_in_robot;
    const double time_s = scan.time_offsets_s.empty()
                              ? beam_period_s * static_cast<double>(beam)
                              : static_cast<double>(scan.time_offsets_s[beam]);
    deskewed.beam_of_hit.push_back(static_cast<int32_t>(beam));
    deskewed.time_of_hit_s.push_back(static_cast<float>(time_s));
    deskewed.hits_in_robot.col(used++) =
        time_s == 0.0 ? hit_in_robot : velocity.after(time_s) * hit_in_robot;
  }
  deskewed.hits_in_robot.conservativeResize(2, used);
  deskewed.no_return = deskewed.beams - static_cast<int>(used);
  return deskewed;
}

DeskewedScan deskewed_again(DeskewedScan scan,
                            std::vector<float> time_of_hit_s,
                            const Velocity2& velocity) {
  for (std::size_t hit = 0; hit < time_of_hit_s.size(); ++hit) {
    const auto column = static_cast<Eigen::Index>(hit);
    const Eigen::Vector2d at_first_beam = scan.hits_in_robot.col(column);
    const Pose2 before = scan.velocity.after(static_cast<double>(scan.time_of_hit_s[hit]));
    const Pose2 now = velocity.after(static_cast<double>(time_of_hit_s[hit]));
    scan.hits_in_robot.col(column) = now * (before.inverse() * at_first_beam);
  }
  scan.time_of_hit_s = std::move(time_of_hit_s);
  scan.velocity = velocity;
  return scan;
}

Pose2 first_from_middle(const DeskewedScan& scan) {
  if (scan.time_of_hit_s.empty()) return {};
  double sum_s = 0.0;
  for (const float time_s : scan.time_of_hit_s) sum_s += static_cast<double>(time_s);
  return scan.velocity.after(sum_s / static_cast<double>(scan.time_of_hit_s.size()));
}

}  // namespace marco
