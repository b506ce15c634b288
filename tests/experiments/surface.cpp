// How whole the 3D model of a recording is, without any truth: surface RECORDING [FOLDER [CONFIG]].
// Each return is judged by its neighbours in the sweep; printed is how many of each class, and of
// each range, have no surface within 10 cm. Second sheets: the part of the model's area that has
// another sheet facing the same way within so much behind it. With FOLDER a picture of each sweep:
// grey has surface, and colours are the classes of what has none; and the model as model.ply.
#include <array>
#include <cstdio>
#include <filesystem>

#include "common/files/ply.hpp"
#include "common/mesh_distance.hpp"
#include "common/mesh_samples.hpp"
#include "lcm_tools/process/config.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "tests/support/return_classes.hpp"
#include "tests/support/second_sheets.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/map_options.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using testing::kReturnClasses;
using testing::ReturnClass;

constexpr float kNearM = 0.10F;
constexpr std::array<float, 5> kRangesM = {2.0F, 4.0F, 7.0F, 12.0F, 1e9F};
constexpr std::array<viewer::Rgb, 6> kColours = {
    {{0, 0, 0}, {255, 0, 255}, {255, 160, 0}, {255, 0, 0}, {60, 120, 255}, {0, 220, 0}}};

struct Count {
  std::size_t all = 0, bare = 0;
};

struct Table {
  std::array<std::array<Count, kRangesM.size()>, kReturnClasses.size()> cells{};

  void print() const {
    Count all;
    for (const auto& line : cells) {
      for (const Count& cell : line) all.all += cell.all;
      for (const Count& cell : line) all.bare += cell.bare;
    }
    std::printf("%-8s", "class");
    for (const float range : kRangesM) {
      range < 1e8F ? std::printf("         < %2.0f m", static_cast<double>(range))
                   : std::printf("      farther");
    }
    std::printf("   share of the returns, of those without surface\n");
    for (std::size_t c = 1; c < cells.size(); ++c) {
      Count sum;
      std::printf("%-8s", kReturnClasses[c]);
      for (const Count& cell : cells[c]) {
        std::printf("  %5zu/%6zu", cell.bare, cell.all);
        sum.all += cell.all;
        sum.bare += cell.bare;
      }
      std::printf("   %5.2f %%  %5.2f %%\n", part(sum.all, all.all), part(sum.bare, all.all));
    }
    std::printf("returns without surface within 10 cm: %.2f %% of %zu\n", part(all.bare, all.all),
                all.all);
  }
  static double part(std::size_t of, std::size_t all) {
    return 100.0 * static_cast<double>(of) / static_cast<double>(std::max<std::size_t>(1, all));
  }
};

/// Where returns lose their surface: the facets of their own sweep, or what is made of them.
struct Stages {
  std::size_t no_facet = 0, carved = 0, island = 0, other = 0;

  void print(std::size_t all) const {
    std::printf("lost: no facet %.2f, carved %.2f, small island %.2f, otherwise %.2f %%\n",
                Table::part(no_facet, all), Table::part(carved, all), Table::part(island, all),
                Table::part(other, all));
  }
};

viewer::Picture judge(const mapping3d::ScenePoints& scene,
                      const MeshDistance& distance,
                      Table& table) {
  const testing::ReturnClasses classes(scene);
  viewer::Picture picture(static_cast<int>(scene.columns), static_cast<int>(scene.rows), {});
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t column = 0; column < scene.columns; ++column) {
      const std::size_t i = scene.index(row, column);
      const ReturnClass kind = classes(row, column);
      if (kind == ReturnClass::none) continue;
      std::size_t bin = 0;
      while (classes.range_m(i) >= kRangesM[bin]) ++bin;
      Count& cell = table.cells[static_cast<std::size_t>(kind)][bin];
      const bool bare = distance(scene.points_m[i]) >= kNearM;
      ++cell.all;
      cell.bare += bare ? 1 : 0;
      const auto grey = static_cast<uint8_t>(60.0F + 160.0F / (1.0F + 0.3F * classes.range_m(i)));
      picture.at(static_cast<int>(scene.columns - 1 - column), static_cast<int>(row)) =
          bare ? kColours[static_cast<std::size_t>(kind)] : viewer::Rgb{grey, grey, grey};
    }
  }
  return picture;
}

void print_sheets(const TriangleMesh& model) {
  const auto [near, middle, far] = testing::second_sheets(model);
  std::printf("second sheets within 2, 5, 15 cm: %.2f %.2f %.2f %% of the samples\n", 100.0 * near,
              100.0 * middle, 100.0 * far);
}

TriangleMesh facet_mesh(const mapping3d::ScenePoints& scene,
                        const mapping3d::BeamNoise& noise,
                        const mapping3d::SurfaceOptions& options) {
  const mapping3d::SmoothScene smoothed = mapping3d::smooth(scene, noise, options.smoothing);
  TriangleMesh mesh;
  mesh.vertices_m = smoothed.points_m;
  mesh.triangles = mapping3d::facets(smoothed, options.facets);
  return mesh;
}

void print_stages(const std::vector<mapping3d::ScenePoints>& scenes,
                  const MeshDistance& distance,
                  const mapping3d::SurfaceOptions& options) {
  mapping3d::SurfaceOptions uncarved = options, unbounded = options;
  uncarved.carve_ratio = 1e9;
  unbounded.min_component_m2 = uncarved.min_component_m2 = 0.0;
  const TriangleMesh with_islands = fuse(scenes, unbounded), with_all = fuse(scenes, uncarved);
  const MeshDistance to_islands(with_islands, kNearM), to_all(with_all, kNearM);
  const mapping3d::BeamNoise noise = mapping3d::learn_noise(scenes, options.smoothing);
  Stages stages;
  std::size_t all = 0;
  for (const mapping3d::ScenePoints& scene : scenes) {
    const TriangleMesh facets = facet_mesh(scene, noise, options);
    const MeshDistance to_facets(facets, kNearM);
    for (std::size_t i = 0; i < scene.points_m.size(); ++i) {
      if (scene.valid[i] == 0) continue;
      ++all;
      const Eigen::Vector3f& point = scene.points_m[i];
      if (distance(point) < kNearM) continue;
      std::size_t& stage = to_facets(point) >= kNearM   ? stages.no_facet
                           : to_islands(point) < kNearM ? stages.island
                           : to_all(point) < kNearM     ? stages.carved
                                                        : stages.other;
      ++stage;
    }
  }
  stages.print(all);
}

void run(const std::filesystem::path& recording,
         const std::filesystem::path& pictures,
         const std::string& config) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "marco_surface";
  std::filesystem::create_directories(folder);
  const auto options = process::load_options<MapOptions>(config);
  MapJob job(options, PathMaker::scans, folder);
  job.read({recording}, ForeignTable{});
  job.finish();
  const mapping3d::Mapper3d& mapper = job.mapping3d().mapper();
  const TriangleMesh& model = mapper.model();
  if (model.triangles.empty()) throw std::invalid_argument(recording.string() + ": no model");
  const MeshDistance distance(model, kNearM);
  Table table;
  int number = 0;
  for (const mapping3d::ScenePoints& scene : mapper.placed()) {
    const viewer::Picture picture = judge(scene, distance, table);
    if (pictures.empty()) continue;
    write_png(picture, pictures / ("sweep" + std::to_string(number++) + ".png"));
  }
  if (!pictures.empty()) files::write_ply(pictures / "model.ply", model);
  table.print();
  print_stages(mapper.placed(), distance, options.joined_surface.surface);
  std::printf("surface: %.1f m2\n", surface_area_m2(model));
  print_sheets(model);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  marco::run(argv[1], argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
  return 0;
}
