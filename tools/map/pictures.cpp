#include "tools/map/pictures.hpp"

#include <algorithm>

#include "common/trajectory_fit.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/process/render_command.hpp"

namespace marco {
namespace {

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

}  // namespace

void draw_map_picture(const std::filesystem::path& path, const GridMap& map, const MapJob& job) {
  viewer::Scene scene;
  scene.grid = map;
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
  viewer::write_png(viewer::draw_map(scene).picture, path.string());
}

void draw_model_picture(const std::filesystem::path& path, TriangleMesh model) {
  viewer::Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(std::move(model))});
  viewer::write_png(viewer::render_scene(std::move(scene), {}), path.string());
}

}  // namespace marco
