#include "tools/map/pictures.hpp"

#include <algorithm>
#include <optional>

#include "common/trajectory_fit.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/process/render_command.hpp"

namespace marco {
namespace {

constexpr viewer::Rgb kWallGreen{36, 150, 62};

Trajectory moved(const Trajectory& trajectory, const Pose2& to_from) {
  Trajectory result = trajectory;
  for (StampedPose2& pose : result) pose.world_from_robot = to_from * pose.world_from_robot;
  return result;
}

// Odometry that has drifted out of the map would only make the picture small.
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

void add_paths(const GridMap& map, const MapJob& job, viewer::Scene& scene) {
  const Trajectory estimate = job.trajectory();
  const Trajectory& odometry = job.odometry_trajectory();
  if (!odometry.empty() && !estimate.empty()) {
    const Pose2 world_from_odom =
        estimate.front().world_from_robot * odometry.front().world_from_robot.inverse();
    scene.paths.push_back(
        {within(moved(odometry, world_from_odom), map), viewer::palette::kOdometry, "odometry"});
  }
  if (!job.truth().empty()) {
    const TrajectoryFit fit = fit_to_truth(estimate, job.truth());
    if (fit.count >= 2) {
      scene.paths.push_back({moved(job.truth(), fit.truth_from_estimate.inverse()),
                             viewer::palette::kTruth, "truth"});
    }
  }
  scene.paths.push_back({estimate, viewer::palette::kEstimate, "estimate"});
}

void add_walls(const Walls& walls, viewer::Scene& scene) {
  for (const Wall& wall : walls) {
    scene.walls.push_back({wall.start_m, wall.end_m, 2.5, kWallGreen});
    scene.ellipses.push_back({wall.start_m, wall.covariance.topLeftCorner<2, 2>()});
    scene.ellipses.push_back({wall.end_m, wall.covariance.bottomRightCorner<2, 2>()});
  }
}

// A level scan in the middle of the recording, where there is a map to see it on.
std::optional<std::size_t> scan_to_show(const MapJob& job) {
  const std::size_t count = job.scans().size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t scan = (count / 2 + i) % count;
    if (job.scans()[scan].level) return scan;
  }
  return std::nullopt;
}

}  // namespace

void draw_line_pictures(const std::filesystem::path& folder,
                        const GridMap& map,
                        const Walls& walls,
                        const MapJob& job) {
  viewer::Scene plan;
  add_walls(walls, plan);
  add_paths(map, job, plan);
  const Trajectory trajectory = job.trajectory();
  if (!trajectory.empty()) plan.robots.push_back({trajectory.back().world_from_robot});
  viewer::write_png(viewer::draw_map(plan).picture, (folder / "lines.png").string());
  if (const auto shown = scan_to_show(job)) {
    viewer::Scene scan;
    add_walls(walls, scan);
    const Pose2& world_from_robot = trajectory[*shown].world_from_robot;
    viewer::PointsItem points{{}, viewer::palette::kOdometry, "scan"};
    const Points2 hits = world_from_robot * job.scans()[*shown].prepared.hits_in_robot;
    for (Eigen::Index i = 0; i < hits.cols(); ++i) {
      points.points_m.emplace_back(static_cast<float>(hits(0, i)), static_cast<float>(hits(1, i)),
                                   0.0F);
    }
    scan.points.push_back(std::move(points));
    scan.robots.push_back({world_from_robot});
    viewer::write_png(viewer::draw_map(scan).picture, (folder / "lines_scan.png").string());
  }
  if (walls.empty()) return;
  plan.ellipses.clear();
  viewer::write_png(viewer::render_scene(std::move(plan), {}), (folder / "lines_3d.png").string());
}

void draw_map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job) {
  viewer::Scene scene;
  scene.grid = map;
  add_paths(map, job, scene);
  viewer::write_png(viewer::draw_map(scene).picture, path.string());
}

void draw_model_picture(const std::filesystem::path& path, TriangleMesh model) {
  viewer::Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(std::move(model))});
  viewer::write_png(viewer::render_scene(std::move(scene), {}), path.string());
}

}  // namespace marco
