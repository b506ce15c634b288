// Which beams went through the surface of a SurfaceModel, and what follows.
#include <algorithm>

#include "mapping3d/surface/surface_model.hpp"

namespace marco::mapping3d {
namespace {

constexpr float kFreeStepM = 0.002F;  // of how far a beam sees free space

// A reflected beam ends so far behind the wall and the margin of carving: by less a pose may err.
constexpr float kBehindM = 0.1F;
// The wall continues so far on all sides: near an edge a pose may err.
constexpr float kMiddleM = 0.1F;
// Facets in 3 x 3 x 3 voxels that make a wall: three scenes' (18 of each that sees all of it).
constexpr int kWallFacets = 50;
// Most votes of beams through it for each of them: half of what carves it. A pane of glass that
// lets half of the beams pass has more.
constexpr double kMostPassing = 0.12;
// Beams of a scene: fewer are errors at edges.
constexpr std::size_t kFewest = 8;

struct Place {
  std::size_t row, column;
};
/// Of a beam as FreeBeams count them.
Place place_of(std::size_t beam, std::size_t columns, std::size_t every) {
  const std::size_t beams_a_row = (columns + every - 1) / every;
  return {beam / beams_a_row * every, beam % beams_a_row * every};
}

}  // namespace

SurfaceModel::FreeBeams SurfaceModel::free_beams(const SmoothScene& scene) const {
  const auto every = static_cast<std::size_t>(options_.carve_every);
  const auto margin_m = static_cast<float>(options_.carve_margin_m);
  FreeBeams free;
  for (std::size_t row = 0; row < scene.rows; row += every) {
    for (std::size_t column = 0; column < scene.columns; column += every) {
      const std::size_t i = row * scene.columns + column;
      free.push_back(0);
      if (scene.kinds[i] == SmoothScene::Kind::none) continue;
      const Eigen::Vector3f beam = scene.points_m[i] - scene.origins_m[row];
      const float range_m = beam.norm();
      const float cosine = -beam.dot(scene.normals[i]) / std::max(1e-6F, range_m);
      const float free_m = range_m - margin_m / std::max(0.05F, cosine);
      free.back() = static_cast<uint16_t>(std::clamp(free_m / kFreeStepM, 0.0F, 65535.0F));
    }
  }
  return free;
}

template <class Visit>
void SurfaceModel::follow(const ScenePoints& scene,
                          const FreeBeams& free,
                          std::size_t beam,
                          const Visit& visit) const {
  if (free[beam] == 0) return;
  const auto every = static_cast<std::size_t>(options_.carve_every);
  const auto [row, column] = place_of(beam, scene.columns, every);
  const auto per_m = static_cast<float>(1.0 / options_.voxel_m);
  const Eigen::Vector3f& origin = scene.origins_m[row];
  const Eigen::Vector3f way = scene.points_m[scene.index(row, column)] - origin;
  const float length = static_cast<float>(free[beam]) * kFreeStepM * per_m;
  const Eigen::Vector3f from = origin * per_m, direction = way / std::max(1e-6F, way.norm());
  voxels_.walk(from, direction, length, [&](Voxel& voxel, float t) {
    if (known(voxel) && distance(voxel) < kSolid) visit(voxel, from + t * direction, length - t);
  });
}

std::vector<uint32_t> SurfaceModel::carve(const ScenePoints& scene, const FreeBeams& free) {
  const auto behind = kBehindM / static_cast<float>(options_.voxel_m);
  std::vector<uint32_t> passed;
  for (std::size_t beam = 0; beam < free.size(); ++beam) {
    float farthest = 0.0F;
    follow(scene, free, beam, [&](Voxel& voxel, const Eigen::Vector3f&, float on) {
      count_up(voxel.through);
      farthest = std::max(farthest, on);
    });
    if (farthest > behind) passed.push_back(static_cast<uint32_t>(beam));
  }
  if (passed.size() < kFewest) passed.clear();
  return passed;
}

std::vector<uint32_t> SurfaceModel::reflected(const ScenePoints& scene,
                                              const FreeBeams& free,
                                              const std::vector<uint32_t>& passed) const {
  const auto behind = kBehindM / static_cast<float>(options_.voxel_m);
  std::vector<uint32_t> found;
  for (const uint32_t beam : passed) {
    bool is_reflected = false;
    follow(scene, free, beam, [&](const Voxel& voxel, const Eigen::Vector3f& at, float on) {
      if (is_reflected || on < behind) return;
      is_reflected = is_wall((at.array() + 0.5F).floor().cast<int>(), voxel);
    });
    if (is_reflected) found.push_back(beam);
  }
  if (found.size() < kFewest) found.clear();
  return found;
}

void SurfaceModel::leave_out(const std::vector<uint32_t>& beams,
                             const SurfaceOptions& options,
                             SmoothScene& scene) {
  const auto every = static_cast<std::size_t>(options.carve_every);
  for (const uint32_t beam : beams) {
    const auto [row, column] = place_of(beam, scene.columns, every);
    for (std::size_t i = row - std::min(row, every - 1); i < std::min(row + every, scene.rows);
         ++i) {
      for (std::size_t j = column - std::min(column, every - 1);
           j < std::min(column + every, scene.columns); ++j) {
        scene.kinds[i * scene.columns + j] = SmoothScene::Kind::none;
      }
    }
  }
}

SurfaceModel::Votes SurfaceModel::votes_about(const Cell& cell) const {
  Votes votes;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const Voxel* voxel = voxels_.find_voxel(cell + Cell(x, y, z));
        if (voxel == nullptr || !known(*voxel) || distance(*voxel) >= kSolid) continue;
        votes.through += voxel->through;
        votes.seen += voxel->seen;
      }
    }
  }
  return votes;
}

bool SurfaceModel::gone(const Cell& cell) const {
  const Votes votes = votes_about(cell);
  return votes.through >= 3 && votes.through > options_.carve_ratio * votes.seen;
}

bool SurfaceModel::is_wall(const Cell& cell, const Voxel& voxel) const {
  const Votes votes = votes_about(cell);
  if (votes.seen < kWallFacets || votes.through > kMostPassing * votes.seen) return false;
  const Eigen::Vector3f normal = voxel.facing.unpacked();
  const Eigen::Vector3f u = normal.unitOrthogonal(), v = normal.cross(u);
  const auto reach = kMiddleM / static_cast<float>(options_.voxel_m);
  for (const Eigen::Vector3f& aside : {u, v, Eigen::Vector3f(-u), Eigen::Vector3f(-v)}) {
    const Cell beside = cell + (reach * aside).array().round().cast<int>().matrix();
    const Voxel* other = voxels_.find_voxel(beside);
    if (other == nullptr || !known(*other)) return false;
  }
  return true;
}

}  // namespace marco::mapping3d
