#pragma once

#include "tests/unit/plan/two_rooms.hpp"

namespace marco::plan::testing {

/// A round room of 3 m radius with a wall of 0.2 m, and around it a corridor whose outer wall has a
/// radius of 5 m. A door of 0.9 m leads from the one to the other, along x. A cupboard of 1 m width
/// stands at the outer wall, opposite the door, 0.5 m into the corridor.
struct RoundRooms {
  static constexpr double kRoomM = 3.0, kCorridorFromM = 3.2, kCorridorToM = 5.0, kDoorM = 0.9;

  static double range(const Eigen::Vector2d& at, const Eigen::Vector2d& way) {
    double nearest = 30;
    const auto in_door = [](const Eigen::Vector2d& point) {
      return point.x() > 0 && std::abs(point.y()) < kDoorM / 2;
    };
    for (const double radius : {kRoomM, kCorridorFromM, kCorridorToM}) {
      const double middle = -way.dot(at),
                   gap = radius * radius - at.squaredNorm() + middle * middle;
      if (gap <= 0) continue;
      for (const double range : {middle - std::sqrt(gap), middle + std::sqrt(gap)}) {
        const bool open = radius < kCorridorToM && in_door(at + range * way);
        if (range > 0 && !open) nearest = std::min(nearest, range);
      }
    }
    for (const double y : {-kDoorM / 2, kDoorM / 2}) {  // the door's jambs
      const double range = (y - at.y()) / way.y(), x = at.x() + range * way.x();
      const bool met = x > std::sqrt(kRoomM * kRoomM - y * y) &&
                       x < std::sqrt(kCorridorFromM * kCorridorFromM - y * y);
      if (range > 0 && met) nearest = std::min(nearest, range);
    }
    constexpr double kFrontX = -4.5, kHalfM = 0.5;
    const double front = (kFrontX - at.x()) / way.x();
    if (front > 0 && std::abs(at.y() + front * way.y()) < kHalfM)
      nearest = std::min(nearest, front);
    for (const double y : {-kHalfM, kHalfM}) {
      const double side = (y - at.y()) / way.y();
      if (side > 0 && at.x() + side * way.x() < kFrontX) nearest = std::min(nearest, side);
    }
    return nearest;
  }

  static std::vector<slam::Keyframe> keyframes() {
    std::mt19937 random(8);
    std::vector<slam::Keyframe> keys;
    for (double x = -2.2; x < 2.3; x += 0.55) {
      for (double y = -2.2; y < 2.3; y += 0.55) {
        if (std::hypot(x, y) < 2.4) keys.push_back(look_around({x, y, 0.7 * x}, range, random));
      }
    }
    for (int i = 0; i < 48; ++i) {
      const double angle = deg_to_rad(7.5 * i);
      const Pose2 pose{4.1 * std::cos(angle), 4.1 * std::sin(angle), 1.3 * angle};
      keys.push_back(look_around(pose, range, random));
    }
    return keys;
  }
};

}  // namespace marco::plan::testing
