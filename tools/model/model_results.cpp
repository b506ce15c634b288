#include "tools/model/model_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "tools/map/joined_surface.hpp"

namespace marco {
namespace {

using mapping3d::RegistrationResult;
using nlohmann::json;

std::string pose_line(const CloudScan& scan) {
  const Eigen::Vector3d at = scan.world_from_scanner.translation();
  const Eigen::Quaterniond turn(scan.world_from_scanner.linear());
  char text[200];
  std::snprintf(text, sizeof text, " %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", at.x(), at.y(), at.z(),
                turn.x(), turn.y(), turn.z(), turn.w());
  return scan.name() + text;
}

PointCloud in_world(PointCloud cloud, const Pose3& world_from_scanner) {
  const Eigen::Isometry3f pose = world_from_scanner.cast<float>();
  for (Eigen::Vector3f& point_m : cloud.points_m) point_m = pose * point_m;
  cloud.world_from_scanner.reset();
  return cloud;
}

// Without beams that did not return.
void append(PointCloud& all, const PointCloud& some) {
  for (std::size_t i = 0; i < some.points_m.size(); ++i) {
    if (!some.points_m[i].allFinite()) continue;
    all.points_m.push_back(some.points_m[i]);
    if (!some.intensities.empty()) all.intensities.push_back(some.intensities[i]);
    if (!some.colors_rgb.empty()) all.colors_rgb.push_back(some.colors_rgb[i]);
  }
}

std::string reason_of_doubt(const CloudModel& model,
                            const std::vector<CloudScan>& scans,
                            const std::vector<std::string>& left_out) {
  const RegistrationResult& joined = model.registration;
  if (!left_out.empty()) {
    return std::to_string(left_out.size()) + " of " +
           std::to_string(left_out.size() + scans.size()) + " scans are left out";
  }
  if (scans.size() < 2 || joined.world_from_placed.empty()) return "";
  if (joined.status != RegistrationResult::Status::converged) {
    return "the scans keep their given poses: " + to_string(joined.status);
  }
  const auto loose = std::count(joined.joined.begin(), joined.joined.end(), false);
  if (loose == 0) return "";
  return std::to_string(loose) + " of " + std::to_string(scans.size()) +
         " scans share too little with the others, or contradict their poses: they keep their "
         "given poses";
}

}  // namespace

void write_poses(const std::filesystem::path& path, const std::vector<CloudScan>& scans) {
  std::string text = "# file x y z [m] qx qy qz qw\n";
  for (const CloudScan& scan : scans) text += pose_line(scan);
  files::write_whole_file(path, text);
}

void write_all_points(const std::filesystem::path& folder,
                      files::PointFormat format,
                      const std::string& ending,
                      const std::vector<CloudScan>& scans) {
  PointCloud all;
  bool intensities = true, colors = true;
  for (const CloudScan& scan : scans) {
    PointCloud cloud = files::read_points(scan.path);
    if (format == files::PointFormat::uos) {
      cloud.world_from_scanner = scan.world_from_scanner;
      std::filesystem::create_directories(folder / "points");
      files::write_points(folder / "points" / (scan.path.stem().string() + ".3d"), format, cloud);
      continue;
    }
    intensities = intensities && !cloud.intensities.empty();
    colors = colors && !cloud.colors_rgb.empty();
    append(all, in_world(std::move(cloud), scan.world_from_scanner));
  }
  if (format == files::PointFormat::uos) return;
  if (!intensities) all.intensities.clear();
  if (!colors) all.colors_rgb.clear();
  files::write_points(folder / ("points." + ending), format, all);
}

void write_model_report(const std::filesystem::path& path,
                        const CloudModel& model,
                        const std::vector<CloudScan>& scans,
                        const std::vector<std::string>& left_out,
                        const StageClock& clock) {
  const RegistrationResult& joined = model.registration;
  json all = json::array();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const mapping3d::ScenePoints& scene = scans[i].grid.scene;
    all.push_back({{"file", scans[i].path.string()},
                   {"points", scans[i].points},
                   {"rows", scene.rows},
                   {"columns", scene.columns},
                   {"joined", i < joined.joined.size() && joined.joined[i]}});
  }
  const json report = {{"scans", all},
                       {"left_out", left_out},
                       {"model", figures_of(model.mesh, model.joined, scans.size())},
                       {"registration",
                        {{"status", to_string(joined.status)},
                         {"overlaps", joined.overlaps},
                         {"refused", joined.refused},
                         {"median_before_m", joined.before.median_m},
                         {"median_after_m", joined.after.median_m},
                         {"p90_before_m", joined.before.p90_m},
                         {"p90_after_m", joined.after.p90_m}}},
                       {"reason_of_doubt", reason_of_doubt(model, scans, left_out)},
                       {"cpu_s", clock.total_cpu_s()},
                       {"wall_s", clock.total_wall_s()},
                       {"peak_memory_mb", StageClock::peak_memory_mb()}};
  files::write_whole_file(path, report.dump(1) + "\n");
}

void print_model_summary(const CloudModel& model,
                         const std::vector<CloudScan>& scans,
                         const std::vector<std::string>& left_out,
                         const StageClock& clock,
                         const std::string& out) {
  const RegistrationResult& joined = model.registration;
  std::size_t points = 0;
  for (const CloudScan& scan : scans) points += scan.points;
  std::printf("%zu scans, %zu points; %zu triangles, %zu in model.glb\n", scans.size(), points,
              model.mesh.triangles.size(), model.joined.simplified.mesh.triangles.size());
  if (joined.overlaps > 0) {
    std::printf(
        "%zu pairs of scans overlap; their surfaces are %.1f mm apart (median), %.1f before\n",
        joined.overlaps, 1e3 * joined.after.median_m, 1e3 * joined.before.median_m);
  }
  std::printf("%.2f s, %.2f s of CPU, peak memory %.0f MB; the results are in %s\n",
              clock.total_wall_s(), clock.total_cpu_s(), StageClock::peak_memory_mb(), out.c_str());
  const std::string doubt = reason_of_doubt(model, scans, left_out);
  std::printf("verdict: %s\n", doubt.empty() ? "good" : ("doubtful: " + doubt).c_str());
}

}  // namespace marco
