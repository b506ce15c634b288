#pragma once

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "common/pose2.hpp"
#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d::testing {

/// A closed world of axis-aligned boxes, met from inside (a room) or outside.
struct Box {
  Eigen::Vector3d low, high;
};

inline const Box kRoom{{-3, -2, 0}, {3, 2, 2.6}};

/// Distance along a ray to the first wall: entering an obstacle, or leaving the room.
inline double cast(const Box& room,
                   const std::vector<Box>& obstacles,
                   const Eigen::Vector3d& from,
                   const Eigen::Vector3d& way) {
  const auto span = [&](const Box& box) {
    double enter = -1e9, leave = 1e9;
    for (int i = 0; i < 3; ++i) {
      const double a = (box.low[i] - from[i]) / way[i], b = (box.high[i] - from[i]) / way[i];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return std::pair(enter, leave);
  };
  double nearest = span(room).second;
  for (const Box& box : obstacles) {
    const auto [enter, leave] = span(box);
    if (enter > 0.0 && enter < leave) nearest = std::min(nearest, enter);
  }
  return nearest;
}

struct Sweep {
  Eigen::Vector3d from{0, 0, 0.6};
  double heading_rad = 0.0;
  double sigma_m = 0.01;
  double direction_sigma_rad = 0.0;
  int rows = 60;
  int columns = 121;  ///< over 180 deg
  double tilt_first_deg = -35.0;
  double tilt_step_deg = 1.2;
  unsigned seed = 1;
};

/// What a tilting laser sees of it.
inline ScenePoints sweep(const Box& room, const std::vector<Box>& obstacles, const Sweep& by) {
  ScenePoints scene;
  scene.rows = static_cast<std::size_t>(by.rows);
  scene.columns = static_cast<std::size_t>(by.columns);
  std::mt19937 random(by.seed);
  std::normal_distribution<double> noise(0.0, by.sigma_m);
  for (int row = 0; row < by.rows; ++row) {
    const double tilt = deg_to_rad(by.tilt_first_deg + by.tilt_step_deg * row);
    scene.origins_m.push_back(by.from.cast<float>());
    for (int column = 0; column < by.columns; ++column) {
      const double bearing = deg_to_rad(-90.0 + 180.0 * column / (by.columns - 1));
      const Eigen::Vector3d flat(std::cos(bearing) * std::cos(tilt), std::sin(bearing),
                                 std::cos(bearing) * std::sin(tilt));
      // A hair off the axes, so that no ray runs along a wall.
      const Eigen::Vector3d meant =
          Eigen::AngleAxisd(by.heading_rad + 1e-4, Eigen::Vector3d::UnitZ()) * flat +
          Eigen::Vector3d(1e-7, 2e-7, 3e-7);
      Eigen::Vector3d way = meant;
      if (by.direction_sigma_rad > 0.0) {
        const Eigen::Vector3d error(noise(random), noise(random), noise(random));
        way = (way + by.direction_sigma_rad / by.sigma_m * error).normalized();
      }
      const double range = cast(room, obstacles, by.from, way) + noise(random);
      scene.points_m.push_back((by.from + range * meant).cast<float>());
      scene.valid.push_back(1);
    }
  }
  return scene;
}

/// By the noise that it shows itself.
inline SmoothScene smoothed(const ScenePoints& scene) {
  return smooth(scene, learn_noise({scene}));
}

inline SurfaceOptions coarse() {
  SurfaceOptions options;
  options.voxel_m = 0.05;
  return options;
}

/// Distance from a point to the surfaces of the world.
inline double distance(const Box& room,
                       const std::vector<Box>& obstacles,
                       const Eigen::Vector3d& p) {
  const auto to_box = [&](const Box& box) {
    const Eigen::Vector3d outside = (box.low - p).cwiseMax(p - box.high);
    return outside.maxCoeff() > 0.0 ? outside.cwiseMax(0.0).norm() : -outside.maxCoeff();
  };
  double nearest = to_box(room);
  for (const Box& box : obstacles) nearest = std::min(nearest, to_box(box));
  return nearest;
}

}  // namespace marco::mapping3d::testing
