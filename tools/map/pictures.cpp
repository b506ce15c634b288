#include "tools/map/pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/trajectory_fit.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "viewer/scene.hpp"

namespace marco {
namespace {

constexpr viewer::Rgb kWallGreen{36, 150, 62};
constexpr viewer::Rgb kTruthGrey{120, 120, 120};  // the walls are green

// Odometry that drifts out of the map would only shrink the picture.
Trajectory within(const Trajectory& trajectory, const GridMap& map) {
  constexpr double kMarginM = 5.0;
  const Eigen::Vector2d top =
      map.origin_m + map.resolution_m * Eigen::Vector2d(map.width_cells, map.height_cells);
  Trajectory result;
  for (const StampedPose2& pose : trajectory) {
    const Eigen::Vector2d at = pose.world_from_robot.translation_m();
    const bool inside = (at.array() > map.origin_m.array() - kMarginM).all() &&
                        (at.array() < top.array() + kMarginM).all();
    if (!inside) break;
    result.push_back(pose);
  }
  return result;
}

double sensor_heading_rad(const mapping3d::SceneRow& row) {
  const Pose3 world_from_sensor = lift(row.world_from_robot) * row.robot_from_sensor_first;
  return std::atan2(world_from_sensor.linear()(1, 0), world_from_sensor.linear()(0, 0));
}

bool looked_around(const std::vector<mapping3d::Scene>& scenes) {
  constexpr double kOneWayDeg = 60.0;
  const double first_rad = sensor_heading_rad(scenes.front().rows.front());
  return std::any_of(scenes.begin(), scenes.end(), [first_rad](const mapping3d::Scene& scene) {
    const double turned_rad = normalize_angle(sensor_heading_rad(scene.rows.back()) - first_rad);
    return std::abs(turned_rad) > deg_to_rad(kOneWayDeg);
  });
}

// Over the robot's shoulder, as the viewer's --camera wants it.
std::string camera_behind(const mapping3d::Scene& scene) {
  const mapping3d::SceneRow& row = scene.rows[scene.rows.size() / 2];
  const Pose3 eye = lift(row.world_from_robot) * row.robot_from_sensor_first;
  const double heading_rad = sensor_heading_rad(row);
  char camera[120];
  std::snprintf(camera, sizeof camera, "%.3f,%.3f,%.3f,%.1f,-8",
                eye.translation().x() - std::cos(heading_rad),
                eye.translation().y() - std::sin(heading_rad), eye.translation().z() + 0.9,
                rad_to_deg(heading_rad));
  return camera;
}

constexpr double kLoopRobotM = 0.15;

void add_points(const Points2& hits, viewer::PointsItem& item) {
  for (Eigen::Index i = 0; i < hits.cols(); ++i) {
    const Eigen::Vector2f hit = hits.col(i).cast<float>();
    item.points_m.emplace_back(hit.x(), hit.y(), 0.0F);
  }
}

void add_paths(const GridMap& map, const MapJob& job, viewer::Scene& scene) {
  const Trajectory estimate = job.trajectory();
  const Trajectory odometry = odometry_on_estimate(estimate, job.adapter().odometry_trajectory());
  if (!odometry.empty()) {
    scene.paths.push_back({within(odometry, map), viewer::palette::kOdometry, "odometry"});
  }
  const Trajectory truth = truth_on_estimate(estimate, job.recorded().truth);
  if (!truth.empty()) scene.paths.push_back({truth, viewer::palette::kTruth, "truth"});
  scene.paths.push_back({estimate, viewer::palette::kEstimate, "estimate"});
}

// A single dot is invisible in a picture of a whole corridor; a cross of dots is not.
Points2 thick(const Points2& points) {
  constexpr double kArmM = 0.02;
  const Eigen::Vector2d arms[] = {{0, 0}, {kArmM, 0}, {-kArmM, 0}, {0, kArmM}, {0, -kArmM}};
  Points2 crosses(2, 5 * points.cols());
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (const Eigen::Vector2d& arm : arms) crosses.col(next++) = points.col(i) + arm;
  }
  return crosses;
}

void add_walls(const Walls& walls, viewer::Scene& scene) {
  scene.points.push_back({{}, kWallGreen, "walls"});  // for the legend
  for (const Wall& wall : walls) {
    scene.walls.push_back({wall.start_m, wall.end_m, 2.5, kWallGreen});
    scene.ellipses.push_back({wall.start_m, wall.covariance.topLeftCorner<2, 2>()});
    scene.ellipses.push_back({wall.end_m, wall.covariance.bottomRightCorner<2, 2>()});
  }
}

void add_round_walls(const RoundWalls& walls, viewer::Scene& scene) {
  for (const RoundWall& wall : walls) {
    const std::vector<Eigen::Vector2d> outline = outline_of(wall);
    for (std::size_t i = 1; i < outline.size(); ++i) {
      scene.walls.push_back({outline[i - 1], outline[i], 2.5, kWallGreen});
    }
  }
}

}  // namespace

std::vector<PictureOrder> line_pictures(const std::filesystem::path& folder,
                                        const GridMap& map,
                                        const LineMap& lines,
                                        const MapJob& job) {
  std::vector<PictureOrder> orders;
  viewer::Scene plan;
  add_walls(lines.walls, plan);
  add_round_walls(lines.round_walls, plan);
  add_paths(map, job, plan);
  for (viewer::PathItem& path : plan.paths) {
    if (path.label == "truth") path.color = kTruthGrey;
  }
  const Trajectory trajectory = job.trajectory();
  if (!trajectory.empty()) plan.robots.push_back({trajectory.back().world_from_robot});
  orders.push_back({folder / "lines.png", true, "", plan});
  if (lines.walls.empty()) return orders;
  plan.ellipses.clear();
  orders.push_back({folder / "lines_3d.png", false, "above", std::move(plan)});
  return orders;
}

PictureOrder map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job) {
  PictureOrder order{path, true, "", {}};
  order.scene.grid = map;
  viewer::PointsItem scans;
  scans.label = "scan points";
  for (const slam::Keyframe& key : job.keyframes()) {
    add_points(key.world_from_robot * key.points_in_robot.points, scans);
  }
  if (!scans.points_m.empty()) order.scene.points.push_back(std::move(scans));
  add_paths(map, job, order.scene);
  return order;
}

PictureOrder model_picture(const std::filesystem::path& path,
                           TriangleMesh model,
                           const MapJob& job) {
  PictureOrder order{path, false, "", {}};
  order.scene.meshes.push_back({std::make_shared<const TriangleMesh>(std::move(model))});
  if (!looked_around(job.mapping3d().mapper().scenes())) {
    order.camera = camera_behind(job.mapping3d().mapper().scenes().front());
  }
  return order;
}

std::vector<PictureOrder> loop_pictures(const std::filesystem::path& folder, const MapJob& job) {
  std::vector<PictureOrder> orders;
  const std::vector<slam::Keyframe>& keys = job.keyframes();
  for (const slam::Loop& loop : job.mapper().loops()) {
    char name[24], evidence[120];
    std::snprintf(name, sizeof name, "%03zu.png", orders.size());
    std::snprintf(evidence, sizeof evidence, "after: moved %.2f m, %.1f deg; %.0f %% on walls%s",
                  loop.shift_m, loop.turn_deg, 100.0 * loop.overlap,
                  loop.is_inlier ? "" : "; REJECTED");
    PictureOrder order{folder / name, true, "", {}};
    const Points2& older = keys[static_cast<std::size_t>(loop.from)].points_in_robot.points;
    const Points2& newer = keys[static_cast<std::size_t>(loop.to)].points_in_robot.points;
    const auto add = [&](const Pose2& from_scan, const Points2& hits, const viewer::Rgb& color,
                         const char* label) {
      add_points(from_scan * thick(hits),
                 order.scene.points.emplace_back(viewer::PointsItem{{}, color, label}));
      order.scene.robots.push_back({from_scan, kLoopRobotM, kLoopRobotM, color});
    };
    add({}, older, viewer::palette::kTruth, "older scan");
    add(loop.believed, newer, viewer::palette::kOdometry, "newer scan, before");
    add(loop.from_from_to, newer, viewer::palette::kEstimate, evidence);
    orders.push_back(std::move(order));
  }
  return orders;
}

}  // namespace marco
