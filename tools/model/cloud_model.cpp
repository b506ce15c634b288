#include "tools/model/cloud_model.hpp"

#include <algorithm>
#include <utility>

#include "mapping3d/clouds/color_field.hpp"

namespace marco {
namespace {

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
