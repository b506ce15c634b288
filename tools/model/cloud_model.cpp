#include "tools/model/cloud_model.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "mapping3d/clouds/color_field.hpp"
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

mapping3d::ScenePoints placed(const CloudScan& scan) {
  mapping3d::ScenePoints scene = scan.grid.scene;
  mapping3d::move(scene, scan.world_from_scanner);
  return scene;
}

mapping3d::PlacedScenes all_placed(const std::vector<CloudScan>& scans) {
  return {scans.size(), [&scans](std::size_t i) { return placed(scans[i]); }};
}

// Black to white between these: the few brightest returns, of reflectors, would leave the rest
// dark.
struct GreyScale {
  float darkest = 0.0F;
  float brightest = 1.0F;

  explicit GreyScale(const std::vector<CloudScan>& scans) {
    std::vector<double> sample;
    for (const CloudScan& scan : scans) {
      const std::size_t every = 1 + scan.intensities.size() / 10000;
      for (std::size_t i = 0; i < scan.intensities.size(); i += every) {
        sample.push_back(static_cast<double>(scan.intensities[i]));
      }
    }
    darkest = static_cast<float>(mapping3d::quantile(sample, 0.02));
    brightest = std::max(darkest + 1e-6F, static_cast<float>(mapping3d::quantile(sample, 0.98)));
  }
  std::array<uint8_t, 3> grey(float intensity) const {
    const float part = std::clamp((intensity - darkest) / (brightest - darkest), 0.0F, 1.0F);
    const auto value = static_cast<uint8_t>(255.0F * part);
    return {value, value, value};
  }
};

void paint(const std::vector<CloudScan>& scans, double cube_m, CloudModel& model) {
  const bool has_colors = std::any_of(
      scans.begin(), scans.end(), [](const CloudScan& scan) { return !scan.colors_rgb.empty(); });
  const bool has_intensities = std::any_of(
      scans.begin(), scans.end(), [](const CloudScan& scan) { return !scan.intensities.empty(); });
  if (!has_colors && !has_intensities) return;
  const GreyScale scale(scans);
  mapping3d::ColorField colors(cube_m);
  for (const CloudScan& scan : scans) {
    const auto& given = has_colors ? scan.colors_rgb.size() : scan.intensities.size();
    if (given == 0) continue;
    const mapping3d::ScenePoints scene = placed(scan);
    for (std::size_t cell = 0; cell < scene.points_m.size(); ++cell) {
      const uint32_t point = scan.grid.point_of[cell];
      if (point == mapping3d::GriddedCloud::kNoPoint) continue;
      colors.add(scene.points_m[cell],
                 has_colors ? scan.colors_rgb[point] : scale.grey(scan.intensities[point]));
    }
  }
  colors.paint(model.mesh);
  colors.paint(model.joined.simplified.mesh);
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

CloudModel make_cloud_model(std::vector<CloudScan>& scans, const CloudModelOptions& options) {
  CloudModel model;
  if (options.refine && scans.size() > 1) {
    model.registration = mapping3d::register_scenes(all_placed(scans), options.registration);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      scans[i].world_from_scanner =
          model.registration.world_from_placed[i] * scans[i].world_from_scanner;
    }
  }
  model.mesh = mapping3d::fuse(all_placed(scans), options.joined_surface.surface);
  model.joined = mapping3d::join_surface(model.mesh, options.joined_surface);
  paint(scans, options.joined_surface.surface.voxel_m, model);
  return model;
}

}  // namespace marco
