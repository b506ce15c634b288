#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/grid_map.hpp"
#include "common/pose3.hpp"
#include "common/trajectory.hpp"
#include "common/triangle_mesh.hpp"
#include "viewer/picture.hpp"

namespace marco::viewer {

/// A trajectory as drawn. `label` names it in a legend; "" keeps it out of there.
struct PathItem {
  Trajectory poses;
  Rgb color = palette::kEstimate;
  std::string label;
  double longest_step_m = HUGE_VAL;  ///< no line is drawn between poses farther apart
};

/// Loose points, world frame.
struct PointsItem {
  std::vector<Eigen::Vector3f> points_m;
  Rgb color = palette::kScanPoints;
  std::string label;
};

/// A mesh in the world frame. Shared, since it may be large and is never changed.
struct MeshItem {
  std::shared_ptr<const TriangleMesh> mesh;
  Rgb color{242, 242, 242};  ///< used by Coloring::scene where the mesh has no colours of its own
};

/// An upright wall between two points of the floor.
struct WallItem {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double height_m = 2.5;
  Rgb color{160, 170, 185};
};

/// The robot as a half disc, flat side behind, as the theses draw it.
struct RobotItem {
  Pose2 world_from_robot;
  double radius_m = 0.25;
  double height_m = 0.35;
  Rgb color = palette::kRobot;
};

/// Beams from one place to what they hit.
struct RaysItem {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> ends_m;
  Rgb color{245, 170, 60};
};

/// The ellipse a 2D position lies in with the given number of standard deviations.
struct EllipseItem {
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();
  double sigmas = 3.0;
  Rgb color = palette::kEstimate;

  /// A closed polygon of 48 edges [m]; its first corner is its last.
  std::vector<Eigen::Vector2d> outline_m() const;
};

/// All that one picture shows, in one world frame: x, y on the floor, z up. A plain value: the
/// renderer copies what it needs.
struct Scene {
  std::optional<GridMap> grid;      ///< lies on the floor, z = 0
  double grid_wall_height_m = 0.0;  ///< above 0: the map's walls stand up in 3D (standing_map)
  std::vector<MeshItem> meshes;
  std::vector<PointsItem> points;
  std::vector<PathItem> paths;
  std::vector<WallItem> walls;
  std::vector<RobotItem> robots;
  std::vector<RaysItem> rays;
  std::vector<EllipseItem> ellipses;
};

/// An axis-aligned box. Empty until something finite was added.
struct Box {
  Eigen::Vector3d min_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d max_m = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return !(min_m.array() <= max_m.array()).all(); }
  Eigen::Vector3d center_m() const { return 0.5 * (min_m + max_m); }
  Eigen::Vector3d size_m() const { return max_m - min_m; }
  void add(const Eigen::Vector3d& point_m) {
    if (!point_m.allFinite()) return;
    min_m = min_m.cwiseMin(point_m);
    max_m = max_m.cwiseMax(point_m);
  }
};

/// The box of everything in the scene: of a grid, only its known cells.
Box bounding_box(const Scene& scene);

}  // namespace marco::viewer
