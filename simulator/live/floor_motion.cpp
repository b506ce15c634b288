#include "simulator/live/floor_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace marco::sim {
namespace {

constexpr double kTouchM = 0.01;
constexpr double kLookM = 0.10;

double sign_of(std::mt19937_64& random) { return random() % 2 == 0 ? 1.0 : -1.0; }

double way_to_slip_m(const OdometryOptions& wheels, std::mt19937_64& random) {
  if (wheels.slip_every_m <= 0.0) return std::numeric_limits<double>::infinity();
  return std::exponential_distribution<double>(1.0 / wheels.slip_every_m)(random);
}

// Points along the four sides of the body, frame of the robot.
std::vector<Eigen::Vector2d> points_along(const BodySpec& body) {
  constexpr std::size_t kAlong = 5, kAcross = 3;
  std::vector<Eigen::Vector2d> points;
  points.reserve(2 * (kAlong + kAcross));
  for (const double y : {body.half_width_m, -body.half_width_m}) {
    for (std::size_t i = 0; i < kAlong; ++i) {
      const double part = static_cast<double>(i) / (kAlong - 1);
      points.emplace_back(-body.back_m + part * (body.front_m + body.back_m), y);
    }
  }
  for (const double x : {body.front_m, -body.back_m}) {
    for (std::size_t i = 0; i < kAcross; ++i) {
      const double part = static_cast<double>(i) / (kAcross - 1);
      points.emplace_back(x, (2.0 * part - 1.0) * body.half_width_m);
    }
  }
  return points;
}

}  // namespace

FloorMotion::FloorMotion(const RayCaster& rays,
                         const BodySpec& body,
                         const OdometryOptions& wheels,
                         const Pose2& start,
                         uint64_t seed)
    : rays_(rays),
      body_(body),
      wheels_(wheels),
      random_(seed),
      distance_scale_(1.0 + sign_of(random_) * wheels.distance_error),
      turn_scale_(1.0 + sign_of(random_) * wheels.turn_error),
      drift_rad_per_m_(sign_of(random_) * deg_to_rad(wheels.drift_deg_per_m)),
      to_next_slip_m_(way_to_slip_m(wheels, random_)),
      world_from_robot_(start) {
  validate(wheels, "wheels");
  validate(body, "body");
}

double FloorMotion::clearance_m(const Pose2& world_from_robot, double* bearing_rad) const {
  double nearest = kLookM;
  for (const double z : {0.10, 0.35, 0.60}) {
    if (z > body_.height_m) continue;
    for (const Eigen::Vector2d& of_body : points_along(body_)) {
      const Eigen::Vector2d point = world_from_robot * of_body;
      const auto distance = static_cast<double>(rays_.distance_to_surface_m(
          Eigen::Vector3d(point.x(), point.y(), z).cast<float>(), static_cast<float>(kLookM)));
      if (distance < nearest) {
        nearest = distance;
        *bearing_rad = std::atan2(of_body.y(), of_body.x());
      }
    }
  }
  return nearest;
}

void FloorMotion::roll(double left_m, double right_m, double track_m) {
  double way_m = (left_m + right_m) / 2.0, turn_rad = (right_m - left_m) / track_m;
  if (way_m == 0.0 && turn_rad == 0.0) return;
  to_next_slip_m_ -= std::abs(way_m);
  if (to_next_slip_m_ <= 0.0) {
    slip_left_m_ = wheels_.slip_m;
    to_next_slip_m_ = way_to_slip_m(wheels_, random_);
    turn_rad += sign_of(random_) * deg_to_rad(wheels_.slip_turn_deg);
  }
  if (slip_left_m_ > 0.0) {  // the wheels turn, the robot stands
    slip_left_m_ -= std::abs(way_m);
    way_m = 0.0;
  }
  way_m /= distance_scale_;
  turn_rad = turn_rad / turn_scale_ - drift_rad_per_m_ * std::abs(way_m);
  const Pose2 next = world_from_robot_ * Pose2{way_m * std::cos(turn_rad / 2.0),
                                               way_m * std::sin(turn_rad / 2.0), turn_rad};
  double bearing = 0.0, old_bearing = 0.0;
  const double room = clearance_m(next, &bearing);
  if (room < kTouchM && room < clearance_m(world_from_robot_, &old_bearing)) {
    contact_.bearing_rad = bearing;
    contact_.front = std::abs(bearing) < deg_to_rad(90.0);
    contact_.rear = !contact_.front;
    contact_.blocked = true;
    return;  // the wheels slip on the spot
  }
  contact_.blocked = false;
  if (room > 2.0 * kTouchM) contact_ = {};
  world_from_robot_ = next;
}

}  // namespace marco::sim
