#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace marco::sim {

/// A leg: an upright cylinder on the floor.
struct Leg {
  static constexpr double kRadiusM = 0.07;
  static constexpr double kHeightM = 0.85;

  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
};

/// Where a ray enters a leg, exactly, by its side or its top.
/// @param direction  unit length
/// @returns the range [m], above 0; nothing where the ray misses, or starts inside.
std::optional<double> range_to_leg(const Leg& leg,
                                   const Eigen::Vector3d& origin_m,
                                   const Eigen::Vector3d& direction);

/// Somebody who walks along a chain of waypoints at a steady speed: around where it ends as it
/// begins, otherwise to and fro. One foot stands while the other swings past it, a stride from
/// where it stood, and each foot goes its own side of the way. In closed form. Const: safe from
/// several threads.
class Person {
 public:
  /// @param waypoints_m  two or more
  /// @param ahead_s  how long they have walked at time 0
  /// @throws std::invalid_argument for fewer than two waypoints, or when all are one.
  Person(const std::vector<Eigen::Vector2d>& waypoints_m, double speed_m_per_s, double ahead_s);

  /// Left and right. @param seconds  of the world's clock; may be negative
  std::array<Leg, 2> legs_at(double seconds) const;

 private:
  /// A straight piece of the way.
  struct Piece {
    double starts_m;  ///< length of the way up to here
    Eigen::Vector2d from_m;
    Eigen::Vector2d ahead;  ///< unit length
  };
  void add_piece(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);
  /// @param side  1 = left, -1 = right
  Eigen::Vector2d foothold(double walked_m, double side) const;
  Leg leg_at(double walked_m, double side) const;

  std::vector<Piece> pieces_;  ///< there and back, or around
  double length_m_ = 0.0;
  double speed_m_per_s_;
  double ahead_s_;
};

}  // namespace marco::sim
