#include "tools/map/results.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/files/line_map_files.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/files/result_list.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/slam.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

// The report of a version that wrote no list of its results.
bool is_old_report(const fs::path& path) {
  if (!fs::is_regular_file(path)) return false;
  const auto report = nlohmann::json::parse(files::read_whole_file(path), nullptr, false);
  return report.is_object() && report.contains("peak_memory_mb") && !report.contains("marco");
}

std::vector<std::string> results_of_old_versions(const fs::path& folder) {
  // clang-format off
  std::vector<std::string> names{
      "calibration.toml", "floor_plan.svg", "lines.dxf", "lines.json", "lines.svg", "lines.png",
      "lines_3d.png", "lines_scan.png", "map.marco", "map.pgm", "map.png", "map.yaml", "model.glb",
      "model.obj", "model.ply", "model.png", "model_scenes.ply", "model_textured.glb",
      "model_textured.png", "odometry.tum", "photographs.toml", "plan.dxf", "plan.json", "plan.pdf",
      "plan.svg", "planes.json", "report.json",
      "slam.lcm", "trajectory.tum", "trajectory_live.tum", "truth.tum"};
  // clang-format on
  for (const char* part : {"loops", "photographs"}) {
    if (!fs::is_directory(folder / part)) continue;
    for (const std::string& name : files::files_below(folder / part)) {
      names.push_back((fs::path(part) / name).string());
    }
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("trajectory_session_") && name.ends_with(".tum")) names.push_back(name);
  }
  return names;
}

}  // namespace

std::unique_ptr<files::OutputFolder> open_results(const fs::path& out,
                                                  const std::vector<std::string>& inputs) {
  auto results = std::make_unique<files::OutputFolder>(out, "map");
  for (const std::string& input : inputs) {
    results->keep(input);
    results->keep(fs::path(input) / slam::kSavedMapName);
  }
  if (is_old_report(out / "report.json")) results->drop(results_of_old_versions(out));
  return results;
}

void write_paths(const std::filesystem::path& out,
                 const MapJob& job,
                 const std::optional<SelfCorrection>& correction) {
  files::write_tum(out / "trajectory.tum", job.trajectory());
  files::write_tum(out / "trajectory_live.tum", job.adapter().live_trajectory());
  if (correction && correction->assumed_from_found_robot) {
    Trajectory as_found = job.trajectory();
    for (StampedPose2& pose : as_found) {
      pose.world_from_robot = pose.world_from_robot * *correction->assumed_from_found_robot;
    }
    files::write_tum(out / kPathAsFound, as_found);
  }
  if (!job.adapter().odometry_trajectory().empty()) {
    files::write_tum(out / "odometry.tum", job.adapter().odometry_trajectory());
  }
  if (!job.recorded().truth.poses.empty())
    files::write_tum(out / "truth.tum", job.recorded().truth.poses);
}

void write_sessions(const std::filesystem::path& out, const slam::SavedMap& map) {
  slam::Slam slam;
  slam.restore(map.slam);
  const Trajectory all = slam.trajectory();
  for (std::size_t session = 0; session < map.session_starts.size(); ++session) {
    const auto first = all.begin() + map.session_starts[session];
    const auto last = session + 1 < map.session_starts.size()
                          ? all.begin() + map.session_starts[session + 1]
                          : all.end();
    files::write_tum(out / ("trajectory_session_" + std::to_string(session + 1) + ".tum"),
                     Trajectory(first, last));
  }
}

void write_lines(const std::filesystem::path& out, const LineMap& lines, const MapJob& job) {
  files::write_whole_file(out / "lines.svg", files::lines_svg(lines, job.trajectory()));
  files::write_whole_file(out / "lines.dxf", files::lines_dxf(lines));
  files::write_whole_file(out / "lines.json", files::lines_json(lines));
}

bool same_folder(const fs::path& a, const fs::path& b) {
  std::error_code none;
  return fs::equivalent(a, b, none);
}

}  // namespace marco
