#include "tools/map/judge.hpp"

#include "common/trajectory_fit.hpp"
#include "slam/grid/map_prediction.hpp"
#include "slam/process/mapper2d_adapter.hpp"

namespace marco {

Errors judge_path(const MapJob& job) {
  Errors errors;
  if (job.recorded().truth.poses.empty()) return errors;
  const TrajectoryFit fit = fit_to_truth(job.trajectory(), job.recorded().truth);
  if (fit.count < 2) return errors;
  errors["path error rms_m"] = fit.rms_m;
  errors["path error max_m"] = fit.max_m;
  if (job.recorded().truth.is_by_arrival) errors["true poses late_s"] = fit.truth_late.seconds();
  const TrajectoryFit odometry =
      fit_to_truth(job.adapter().odometry_trajectory(), job.recorded().truth);
  if (odometry.count >= 2) errors["odometry error rms_m"] = odometry.rms_m;
  return errors;
}

Errors judge_held_out(const MapJob& job, const GridMap& map) {
  const std::vector<std::optional<Pose2>> poses = job.mapper().scan_poses();
  std::vector<slam::PlacedScan> placed;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const slam::UsedScan& scan = job.adapter().scans()[i];
    if (!scan.held_out || !scan.level || !poses[i]) continue;
    placed.push_back({*poses[i], scan.hits_in_robot, scan.sensor_in_robot});
  }
  Errors errors;
  if (placed.empty()) return errors;
  const slam::PredictionQuality quality = slam::judge_prediction(map, placed);
  errors["held-out beams"] = static_cast<double>(quality.beams);
  errors["held-out median range error_m"] = quality.median_error_m;
  errors["held-out beams through walls"] = quality.through_walls;
  errors["held-out beams short of walls"] = quality.short_of_walls;
  return errors;
}

}  // namespace marco
