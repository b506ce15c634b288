#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace marco {

/// 2×N points [m], one a column.
using Points2 = Eigen::Matrix2Xd;

constexpr double deg_to_rad(double deg) { return deg * (std::numbers::pi / 180.0); }
constexpr double rad_to_deg(double rad) { return rad * (180.0 / std::numbers::pi); }

/// The same angle in [-π, π).
inline double normalize_angle(double angle_rad) {
  constexpr double kPi = std::numbers::pi;
  if (angle_rad >= -kPi && angle_rad < kPi) return angle_rad;
  const double turned = angle_rad - 2.0 * kPi * std::floor((angle_rad + kPi) / (2.0 * kPi));
  return turned >= kPi ? turned - 2.0 * kPi : turned;
}

/// A pose on the floor. A variable `a_from_b` maps coordinates in frame b into frame a, which is
/// the pose of b in a: `world_from_lidar = world_from_robot * robot_from_lidar`.
struct Pose2 {
  double x_m = 0.0;
  double y_m = 0.0;
  double theta_rad = 0.0;  ///< counter-clockwise

  Eigen::Vector2d translation_m() const { return {x_m, y_m}; }
  Eigen::Matrix2d rotation() const {
    const double c = std::cos(theta_rad), s = std::sin(theta_rad);
    return (Eigen::Matrix2d() << c, -s, s, c).finished();
  }
  /// b_from_a of an a_from_b.
  Pose2 inverse() const {
    const double c = std::cos(theta_rad), s = std::sin(theta_rad);
    return {-c * x_m - s * y_m, s * x_m - c * y_m, normalize_angle(-theta_rad)};
  }
  Eigen::Vector3d vector() const { return {x_m, y_m, theta_rad}; }
  static Pose2 from_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
  bool operator==(const Pose2&) const = default;
};

inline Pose2 operator*(const Pose2& a_from_b, const Pose2& b_from_c) {
  const double c = std::cos(a_from_b.theta_rad), s = std::sin(a_from_b.theta_rad);
  return {a_from_b.x_m + c * b_from_c.x_m - s * b_from_c.y_m,
          a_from_b.y_m + s * b_from_c.x_m + c * b_from_c.y_m,
          normalize_angle(a_from_b.theta_rad + b_from_c.theta_rad)};
}

inline Eigen::Vector2d operator*(const Pose2& a_from_b, const Eigen::Vector2d& point_in_b) {
  return a_from_b.rotation() * point_in_b + a_from_b.translation_m();
}

Points2 operator*(const Pose2& a_from_b, const Points2& points_in_b);

/// Pose of b seen from a, both given in one frame.
inline Pose2 between(const Pose2& w_from_a, const Pose2& w_from_b) {
  return w_from_a.inverse() * w_from_b;
}

/// Straight blend of two poses, the angle along its shorter way. @param part 0 = a, 1 = b.
inline Pose2 interpolate(const Pose2& a, const Pose2& b, double part) {
  return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m),
          normalize_angle(a.theta_rad + part * normalize_angle(b.theta_rad - a.theta_rad))};
}

/// A quarter turn counter-clockwise.
inline Eigen::Vector2d turned_left(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

inline bool is_finite(const Pose2& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.theta_rad);
}

}  // namespace marco
