#include "common/trajectory_fit.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "simulator/ray_caster.hpp"
#include "simulator/truth.hpp"
#include "simulator/world.hpp"
#include "tools/map/judge.hpp"

namespace marco {
namespace {

// Of the beams of level scans: the height at which the map cuts the world.
double laser_height_m(const std::map<std::string, SensorInfo>& sensors) {
  for (const auto& [channel, info] : sensors) {
    if (channel.rfind(channels::kLidar, 0) != 0) continue;
    const SensorInfo* base = find_sensor(sensors, channels::kPanTiltState);
    const auto robot_from_laser = robot_from_sensor(info, base, PanTiltAngles{});
    if (robot_from_laser) return robot_from_laser->translation().z();
  }
  return 0.0;
}

void note(Errors& errors, const std::string& of, const sim::SurfaceError& found) {
  if (found.count == 0) return;
  errors[of + " error rms_m"] = found.rms_m;
  errors[of + " error p95_m"] = found.p95_m;
  errors[of + " error p99_m"] = found.p99_m;
}

}  // namespace

Errors judge_against_world(const MapJob& job,
                           const GridMap& map,
                           const TriangleMesh& model,
                           const std::filesystem::path& world_file) {
  const TrajectoryFit fit = fit_to_truth(job.trajectory(), job.recorded().truth);
  require(fit.count >= 2,
          "--world: the recording has no TRUE_POSE to align the map with the world");
  const sim::RayCaster world(
      sim::build_world(process::load_options<sim::WorldSpec>(world_file.string())));
  Errors errors;
  note(errors, "map",
       sim::map_error(map, world, fit.truth_from_estimate, laser_height_m(job.recorded().sensors)));
  note(errors, "model", sim::model_error(model, world, lift(fit.truth_from_estimate)));
  return errors;
}

}  // namespace marco
