#include "viewer/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::viewer {
namespace {

void add_grid(const GridMap& grid, double height_m, Box& box) {
  for (int y = 0; y < grid.height_cells; ++y) {
    for (int x = 0; x < grid.width_cells; ++x) {
      if (grid.at(x, y) == GridMap::kUnknown) continue;
      const Eigen::Vector2d corner = grid.origin_m + grid.resolution_m * Eigen::Vector2d(x, y);
      box.add({corner.x(), corner.y(), 0.0});
      box.add({corner.x() + grid.resolution_m, corner.y() + grid.resolution_m, height_m});
    }
  }
}

void add_flat(const Eigen::Vector2d& point_m, double height_m, Box& box) {
  box.add({point_m.x(), point_m.y(), height_m});
}

}  // namespace

std::vector<Eigen::Vector2d> EllipseItem::outline_m() const {
  constexpr int kEdges = 48;
  // Eigenvalues and the first eigenvector of a symmetric 2x2 matrix, in closed form.
  const Eigen::Matrix2d& c = covariance_m2;
  const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
  const double apart = std::hypot(half, c(0, 1));
  const double turn_rad = 0.5 * std::atan2(c(0, 1), half);
  const double major_m = sigmas * std::sqrt(std::max(0.0, mean + apart));
  const double minor_m = sigmas * std::sqrt(std::max(0.0, mean - apart));
  const Eigen::Vector2d major = major_m * Eigen::Vector2d(std::cos(turn_rad), std::sin(turn_rad));
  const Eigen::Vector2d minor = minor_m * Eigen::Vector2d(-std::sin(turn_rad), std::cos(turn_rad));
  std::vector<Eigen::Vector2d> corners_m;
  for (int i = 0; i <= kEdges; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / kEdges;
    corners_m.emplace_back(center_m + std::cos(angle_rad) * major + std::sin(angle_rad) * minor);
  }
  return corners_m;
}

Box bounding_box(const Scene& scene) {
  Box box;
  if (scene.grid) add_grid(*scene.grid, scene.grid_wall_height_m, box);
  for (const MeshItem& item : scene.meshes)
    for (const Eigen::Vector3f& vertex : item.mesh->vertices_m) box.add(vertex.cast<double>());
  for (const PointsItem& item : scene.points)
    for (const Eigen::Vector3f& point : item.points_m) box.add(point.cast<double>());
  for (const PathItem& item : scene.paths)
    for (const StampedPose2& pose : item.poses)
      add_flat(pose.world_from_robot.translation_m(), 0.0, box);
  for (const WallItem& wall : scene.walls) {
    add_flat(wall.from_m, 0.0, box);
    add_flat(wall.to_m, wall.height_m, box);
  }
  for (const RobotItem& robot : scene.robots) {
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(robot.radius_m);
    add_flat(robot.world_from_robot.translation_m() - radius, 0.0, box);
    add_flat(robot.world_from_robot.translation_m() + radius, robot.height_m, box);
  }
  return box;
}

}  // namespace marco::viewer
