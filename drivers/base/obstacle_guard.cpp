#include "drivers/base/obstacle_guard.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose3.hpp"

namespace marco::drivers {

ObstacleGuard::ObstacleGuard(const GuardOptions& options) : options_(options) {
  validate(options, "guard");
}

void ObstacleGuard::on_bumpers(std::vector<int> front_pressed, std::vector<int> rear_pressed) {
  front_pressed_ = std::move(front_pressed);
  rear_pressed_ = std::move(rear_pressed);
}

std::string ObstacleGuard::pressed_bumpers(double wanted_m) const {
  const bool ahead = !std::signbit(wanted_m);
  const std::vector<int>& pressed = ahead ? front_pressed_ : rear_pressed_;
  if (!options_.enabled || pressed.empty()) return "";
  std::string text = ahead ? "front bumper" : "rear bumper";
  if (pressed.size() > 1) text += "s";
  for (const int number : pressed) text += " " + std::to_string(number);
  return text + (pressed.size() > 1 ? " are pressed" : " is pressed");
}

void ObstacleGuard::on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now) {
  const auto info = infos_.find(scan.channel);
  if (info == infos_.end()) return;
  Pose3 robot_from_sensor = info->second.parent_from_sensor;
  if (info->second.mount == SensorInfo::Mount::pantilt) {
    const auto base = infos_.find("PANTILT_STATE");
    if (base == infos_.end() || !pantilt_) return;
    robot_from_sensor = robot_from_pantilt_sensor(base->second, info->second, pantilt_->pan_rad,
                                                  pantilt_->tilt_rad);
  }
  Sight sight;
  sight.when = now;
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double range_m = static_cast<double>(scan.ranges_m[beam]);
    if (!(range_m > info->second.range_min_m && range_m < info->second.range_max_m)) continue;
    const double bearing_rad = scan.bearing_rad(beam);
    const Eigen::Vector3d point =
        robot_from_sensor *
        Eigen::Vector3d(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), 0.0);
    if (point.z() < options_.min_height_m || point.z() > options_.max_height_m) continue;
    if (in_body(point.head<2>(), 0.0, 0.0)) continue;  // the robot itself
    sight.points_in_odom.push_back(odom_from_robot * Eigen::Vector2d(point.head<2>()));
  }
  sights_[scan.channel] = std::move(sight);
}

void ObstacleGuard::on_sonar(const SonarRing& ring, const Pose2& odom_from_robot, Utime now) {
  Sight sight;
  sight.when = now;
  for (const SonarReading& reading : ring.readings) {
    if (reading.range_m <= 0.0) continue;
    // Somewhere on the cone's arc: its middle and half way to its rims.
    for (const double part : {-0.25, 0.0, 0.25}) {
      const double bearing_rad = part * ring.cone_rad;
      const Eigen::Vector2d point =
          reading.robot_from_sonar * Eigen::Vector2d(reading.range_m * std::cos(bearing_rad),
                                                     reading.range_m * std::sin(bearing_rad));
      if (in_body(point, 0.0, 0.0)) continue;
      sight.points_in_odom.push_back(odom_from_robot * point);
    }
  }
  sights_["SONAR"] = std::move(sight);
}

bool ObstacleGuard::blind(Utime now) const {
  return std::none_of(sights_.begin(), sights_.end(), [&](const auto& sight) {
    return (now - sight.second.when).seconds() <= options_.max_age_s;
  });
}

std::vector<Eigen::Vector2d> ObstacleGuard::fresh_points(const Pose2& odom_from_robot,
                                                         Utime now) const {
  std::vector<Eigen::Vector2d> points;
  const Pose2 robot_from_odom = odom_from_robot.inverse();
  const double c = std::cos(robot_from_odom.theta_rad), s = std::sin(robot_from_odom.theta_rad);
  for (const auto& [sensor, sight] : sights_) {
    if ((now - sight.when).seconds() > options_.max_age_s) continue;
    for (const Eigen::Vector2d& p : sight.points_in_odom) {
      points.emplace_back(c * p.x() - s * p.y() + robot_from_odom.x_m,
                          s * p.x() + c * p.y() + robot_from_odom.y_m);
    }
  }
  return points;
}

bool ObstacleGuard::in_body(const Eigen::Vector2d& point,
                            double margin_m,
                            double side_margin_m) const {
  return point.x() < options_.front_m + margin_m && point.x() > -options_.back_m - margin_m &&
         std::abs(point.y()) < options_.half_width_m + side_margin_m;
}

double ObstacleGuard::free_move_m(double wanted_m, const Pose2& odom_from_robot, Utime now) const {
  if (!options_.enabled) return wanted_m;
  const bool ahead = wanted_m > 0.0;
  if (!(ahead ? front_pressed_ : rear_pressed_).empty()) return 0.0;
  double free_m = std::abs(wanted_m);
  const double edge_m = ahead ? options_.front_m : options_.back_m;
  for (const Eigen::Vector2d& point : fresh_points(odom_from_robot, now)) {
    if (std::abs(point.y()) > options_.half_width_m + options_.side_margin_m) continue;
    const double along_m = ahead ? point.x() : -point.x();
    if (along_m < edge_m - 0.05) continue;  // beside or behind
    free_m = std::min(free_m, std::max(0.0, along_m - edge_m - options_.margin_m));
  }
  return ahead ? free_m : -free_m;
}

double ObstacleGuard::free_turn_rad(double wanted_rad,
                                    const Pose2& odom_from_robot,
                                    Utime now) const {
  if (!options_.enabled) return wanted_rad;
  const double reach_m =
      std::hypot(std::max(options_.front_m, options_.back_m), options_.half_width_m) +
      options_.side_margin_m;
  std::vector<Eigen::Vector2d> near;
  for (const Eigen::Vector2d& point : fresh_points(odom_from_robot, now)) {
    // A point inside the body already cannot be hit by turning.
    if (point.norm() < reach_m && !in_body(point, options_.side_margin_m, options_.side_margin_m)) {
      near.push_back(point);
    }
  }
  constexpr double kStepRad = deg_to_rad(2.0);
  const double sign = wanted_rad < 0.0 ? -1.0 : 1.0;
  const double size_rad = std::abs(wanted_rad);
  for (double turned = 0.0; turned < size_rad && !near.empty(); turned += kStepRad) {
    const Pose2 turned_from_robot{0.0, 0.0, -sign * (turned + kStepRad)};
    for (const Eigen::Vector2d& point : near) {
      if (in_body(turned_from_robot * point, options_.side_margin_m, options_.side_margin_m)) {
        return sign * turned;
      }
    }
  }
  return wanted_rad;
}

}  // namespace marco::drivers
