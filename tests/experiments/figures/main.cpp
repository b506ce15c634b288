#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <map>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "mapping3d/surface/photograph_list.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "tests/experiments/figures/matching_figures.hpp"
#include "tests/experiments/figures/photograph_figures.hpp"
#include "tests/experiments/figures/thesis_figures.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/map_options.hpp"
#include "tools/map/photographs.hpp"
#include "viewer/process/render_command.hpp"

namespace marco {
namespace {

// A scan each 50 cm or 25 deg of odometry, as thesis B's lab run took them.
std::vector<WalkScan> walk_of(const MapJob& job) {
  constexpr double kStepM = 0.5, kStepDeg = 25.0;
  std::map<int64_t, Pose2> odometry, truth;
  for (const StampedPose2& pose : job.adapter().odometry_trajectory()) {
    odometry[pose.utime.us] = pose.world_from_robot;
  }
  for (const StampedPose2& pose : job.recorded().truth.poses)
    truth[pose.utime.us] = pose.world_from_robot;
  std::vector<WalkScan> scans;
  for (const slam::Keyframe& key : job.keyframes()) {
    const auto odom = odometry.find(key.utime.us);
    if (odom == odometry.end()) continue;
    if (!scans.empty()) {
      const Pose2 step = between(scans.back().odom_from_robot, odom->second);
      const bool far = step.translation_m().norm() >= kStepM - 1e-6 ||
                       std::abs(step.theta_rad) >= deg_to_rad(kStepDeg);
      if (!far) continue;
    }
    WalkScan scan{key.points_in_robot.points, odom->second, {}};
    const auto known = truth.find(key.utime.us);
    if (known != truth.end()) scan.world_from_robot = known->second;
    scans.push_back(std::move(scan));
  }
  return scans;
}

// @param written_to  becomes `out`
void draw_walks(const MapJob& job,
                const std::filesystem::path& written_to,
                const std::filesystem::path& out) {
  const std::vector<WalkScan> scans = walk_of(job);
  if (scans.size() < 2) return;
  const std::vector<MatchedWalk> walks = match_walks(scans);
  for (const Figure& figure : draw_matching_figures(written_to, scans, walks)) {
    std::printf("%s: %s\n", (out / figure.file).c_str(), figure.what.c_str());
  }
  std::printf("%zu moves\n%-50s rms [m]  max [m]  CPU a match [ms]\n", scans.size() - 1, "");
  for (const MatchedWalk& walk : walks) {
    std::printf("%-50s %7.3f  %7.3f  %9.2f\n", walk.name.c_str(), walk.rms_m, walk.max_m,
                walk.ms_per_match);
  }
}

// Written for the figures only, and removed.
std::vector<Figure> draw_photographs(
    const MapJob& job,
    const std::string& log,
    const std::filesystem::path& folder,
    const std::vector<std::vector<mapping3d::ScenePoints>>& stops) {
  if (write_photographs(folder, {log}, job.trajectory(), job.recorded().sensors, {}).chosen == 0)
    return {};
  const std::filesystem::path list = folder / "photographs.toml";
  std::vector<PosedPhotograph> photographs;
  for (const PhotographSpec& spec :
       process::load_options<PhotographList>(list.string()).photographs) {
    Pose3 world_from_camera = Pose3::Identity();
    world_from_camera.linear() = Eigen::Quaterniond(spec.quaternion_xyzw.data()).toRotationMatrix();
    world_from_camera.translation() = Eigen::Vector3d(spec.position_m.data());
    photographs.push_back({folder / spec.file, world_from_camera, spec.focal_px[0]});
  }
  const std::vector<Figure> figures =
      draw_photograph_figures(folder, photographs, stops, job.mapping3d().mapper().model());
  std::filesystem::remove_all(folder / "photographs");
  std::filesystem::remove(list);
  return figures;
}

int run(const std::string& log,
        const std::string& config,
        const std::filesystem::path& out,
        const FigureOptions& figures) {
  auto options = process::load_options<MapOptions>(config);
  process::catch_interrupts(out.string() + " is unchanged");
  files::OutputFolder results(out, "figures");
  results.keep(log);
  results.keep(config);
  MapJob job(options, PathMaker::scans, results.path());
  job.read({log}, process::load_options<ForeignTable>(""));
  job.finish();
  const auto stops = by_stop(job.mapping3d().mapper().scenes());
  require(!stops.empty(), log + ": contains no 3D sweep");
  for (const Figure& figure : draw_thesis_figures(results.path(), stops, figures)) {
    std::printf("%s: %s\n", (out / figure.file).c_str(), figure.what.c_str());
  }
  for (const Figure& figure : draw_photographs(job, log, results.path(), stops)) {
    std::printf("%s: %s\n", (out / figure.file).c_str(), figure.what.c_str());
  }
  draw_walks(job, results.path(), out);
  results.commit();
  std::printf("(thesis B's own scene: 59924 triangles, 29785 quads of 36100 beams)\n");
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("figures", [&] {
    marco::process::CommandLine app(
        "Reproduces figures of thesis B from a recording with 3D sweeps: 5.3-5.11, paths by its "
        "scan matching methods, with their errors and times; 5.13-5.17 and 5.19-5.21, its "
        "polygons, lighting and registration; from a recording with pictures also 5.12 and 5.18.");
    std::string log, config, out = "out/figures", size = "1000x750";
    marco::FigureOptions figures;
    app.add_option("LOG", log).required().existing_path();
    app.add_option("--out", out, "folder for the pictures").shows_default();
    app.add_option("--config", config, "TOML, as for marco map").existing_file();
    app.add_option("--size", size, "WIDTHxHEIGHT [px]").shows_default();
    app.add_option("--cut-ends", figures.cut_ends,
                   "number of beams to leave out at each end of a scan")
        .between(0, 100000)
        .shows_default();
    app.add_choice<marco::viewer::Mode>("--mode", figures.mode,
                                        {{"points", marco::viewer::Mode::points},
                                         {"wire", marco::viewer::Mode::wire},
                                         {"filled", marco::viewer::Mode::filled}},
                                        "points, wire or filled");
    if (const auto code = app.parse(argc, argv)) return *code;
    figures.size = marco::viewer::parse_size(size);
    return marco::run(log, config, out, figures);
  });
}
