#include "tests/experiments/figures/photograph_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "viewer/film.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using mapping3d::ScenePoints;

// Less for one that stands where the laser stood [m] and looks where the sweep does [rad].
double apart(const PosedPhotograph& photograph, const ScenePoints& sweep) {
  const Eigen::Vector3d laser = sweep.origins_m[sweep.rows / 2].cast<double>();
  const Eigen::Vector3d ahead = photograph.world_from_camera.linear().col(2);
  const double cosine = std::clamp(ahead.dot(ahead_of(sweep)), -1.0, 1.0);
  return (photograph.world_from_camera.translation() - laser).norm() + std::acos(cosine);
}

viewer::Camera camera_of(const PosedPhotograph& photograph, int height_px) {
  viewer::Camera camera;
  camera.eye_m = photograph.world_from_camera.translation();
  camera.target_m = photograph.world_from_camera * Eigen::Vector3d::UnitZ();
  camera.up = -photograph.world_from_camera.linear().col(1);
  camera.field_of_view_rad = 2.0 * std::atan(0.5 * height_px / photograph.focal_px);
  return camera;
}

}  // namespace

std::vector<Figure> draw_photograph_figures(const std::filesystem::path& folder,
                                            const std::vector<PosedPhotograph>& photographs,
                                            const std::vector<std::vector<ScenePoints>>& stops,
                                            const TriangleMesh& model) {
  if (photographs.empty() || model.triangles.empty()) return {};
  viewer::Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(model)});
  viewer::Renderer renderer;
  renderer.load(scene);
  constexpr std::array kFigures{std::pair("5_12_photograph.png", "5.12, the first stop"),
                                std::pair("5_18_photograph.png", "5.18, the second stop")};
  std::vector<Figure> figures;
  for (std::size_t i = 0; i < std::min(stops.size(), kFigures.size()); ++i) {
    const ScenePoints sweep = four_ways(stops[i]).front();
    const PosedPhotograph& nearest = *std::min_element(
        photographs.begin(), photographs.end(),
        [&](const auto& a, const auto& b) { return apart(a, sweep) < apart(b, sweep); });
    const viewer::Picture photograph = viewer::read_picture(nearest.file.string());
    const viewer::Picture drawn = renderer.draw(camera_of(nearest, photograph.height_px), {},
                                                {photograph.width_px, photograph.height_px});
    const auto& [file, what] = kFigures.at(i);
    viewer::write_png(viewer::contact_sheet({photograph, drawn}, 2), (folder / file).string());
    figures.push_back({file, std::string(what) + ": photograph and model from the same place"});
  }
  return figures;
}

}  // namespace marco
