#pragma once

#include <string>
#include <vector>

#include "lcm_tools/process/config.hpp"
#include "simulator/tour.hpp"
#include "simulator/world.hpp"
#include "tests/support/lines_world.hpp"

namespace marco::testing {

/// The floor plan of config/worlds/NAME.toml at the laser's height: walls of their thickness with
/// both faces, boxes that reach up to the laser; tables, doors and columns are left out.
inline LinesWorld plan_world(const std::string& name) {
  constexpr double kLaserHeightM = 0.6;
  const auto spec = process::load_options<sim::WorldSpec>("config/worlds/" + name + ".toml");
  LinesWorld world;
  const auto add_solid = [&world](const Eigen::Vector2d& center_m, const Eigen::Vector2d& size_m,
                                  double yaw_rad) {
    const Pose2 place{center_m.x(), center_m.y(), yaw_rad};
    const double x = 0.5 * size_m.x(), y = 0.5 * size_m.y();
    std::vector<Eigen::Vector2d> corners;
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-x, -y), Eigen::Vector2d(-x, y),
                                          Eigen::Vector2d(x, y), Eigen::Vector2d(x, -y)}) {
      corners.push_back(place * corner);
    }
    world.add_polygon(corners);
  };
  for (const sim::WallSpec& wall : spec.walls) {
    for (std::size_t i = 0; i + 3 < wall.corners_m.size(); i += 2) {
      const Eigen::Vector2d a(wall.corners_m[i], wall.corners_m[i + 1]);
      const Eigen::Vector2d b(wall.corners_m[i + 2], wall.corners_m[i + 3]);
      add_solid(0.5 * (a + b), {(b - a).norm() + wall.thickness_m, wall.thickness_m},
                std::atan2(b.y() - a.y(), b.x() - a.x()));
    }
  }
  for (const sim::BoxSpec& box : spec.boxes) {
    if (box.above_floor_m > kLaserHeightM || box.above_floor_m + box.size_m[2] < kLaserHeightM) {
      continue;
    }
    add_solid({box.at_m[0], box.at_m[1]}, {box.size_m[0], box.size_m[1]}, deg_to_rad(box.yaw_deg));
  }
  return world;
}

/// Places that config/tours/NAME.toml goes through, its start first.
inline std::vector<Eigen::Vector2d> tour_waypoints(const std::string& name) {
  const auto tour = process::load_options<sim::Tour>("config/tours/" + name + ".toml");
  std::vector<Eigen::Vector2d> waypoints{{tour.start_m[0], tour.start_m[1]}};
  for (const sim::TourStep& step : tour.steps) {
    if (step.to_m.size() == 2) waypoints.emplace_back(step.to_m[0], step.to_m[1]);
  }
  return waypoints;
}

}  // namespace marco::testing
