#include "mapping3d/surface/surface_model.hpp"

#include <malloc.h>

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"
#include "mapping3d/surface/small_pieces.hpp"
#include "mapping3d/surface/surface_nets.hpp"

namespace marco::mapping3d {
namespace {

int floor_int(float value) { return static_cast<int>(std::floor(value)); }
int ceil_int(float value) { return static_cast<int>(std::ceil(value)); }

constexpr float kFreeStepM = 0.002F;  // of how far a beam sees free space

void count_up(uint8_t& counter) { counter = static_cast<uint8_t>(counter + (counter < 255)); }

}  // namespace

SurfaceModel::SurfaceModel(const SurfaceOptions& options) : options_(options) {
  validate(options, "surface");
}

void SurfaceModel::add(const SmoothScene& scene) {
  const auto per_m = static_cast<float>(1.0 / options_.voxel_m);
  std::vector<Corner> corners(scene.points_m.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (scene.kinds[i] == SmoothScene::Kind::none) continue;
    const Eigen::Vector3f& p = scene.points_m[i];
    const Eigen::Vector3f beam = p - scene.origins_m[i / scene.columns];
    const Eigen::Vector3f& normal = scene.normals[i];
    // Noise across the surface: of the range, and of the scene's orientation.
    const auto own = static_cast<double>(scene.sigmas_m[i]);
    const auto lever_m = static_cast<double>((beam - normal * beam.dot(normal)).norm());
    const double turn = deg_to_rad(options_.pose_sigma_deg) * lever_m;
    const double variance = own * own + turn * turn + options_.pose_sigma_m * options_.pose_sigma_m;
    corners[i] = {p * per_m, normal, static_cast<float>(1e-4 / variance)};
  }
  for (const auto& [a, b, c] : facets(scene, options_.facets)) {
    std::array<Corner, 3> facet{corners[a], corners[b], corners[c]};
    const Eigen::Vector3f flat = (facet[1].at - facet[0].at).cross(facet[2].at - facet[0].at);
    for (std::size_t i = 0; i < 3; ++i) {
      const uint32_t index = i == 0 ? a : i == 1 ? b : c;
      if (scene.kinds[index] == SmoothScene::Kind::loose) {
        facet[i].normal = flat.normalized();
      }
    }
    rasterize(facet);
  }
}

// Scan conversion along the facet's main axis: each lattice line meets the facet at most once, and
// neighbouring facets neither share nor miss a line.
void SurfaceModel::rasterize(const std::array<Corner, 3>& corners) {
  const Eigen::Vector3f normal = corners[0].normal + corners[1].normal + corners[2].normal;
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto &a = corners[0].at, &b = corners[1].at, &c = corners[2].at;
  const int u0 = ceil_int(std::min({a[u], b[u], c[u]})),
            u1 = floor_int(std::max({a[u], b[u], c[u]}));
  const int v0 = ceil_int(std::min({a[v], b[v], c[v]})),
            v1 = floor_int(std::max({a[v], b[v], c[v]}));
  if (u0 > u1 || v0 > v1) return;
  const float area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
  if (std::abs(area) < 1e-9F) return;
  Cell column;
  for (int j = v0; j <= v1; ++j) {
    for (int i = u0; i <= u1; ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      const float wa = ((b[u] - x) * (c[v] - y) - (b[v] - y) * (c[u] - x)) / area;
      const float wb = ((c[u] - x) * (a[v] - y) - (c[v] - y) * (a[u] - x)) / area;
      const float wc = 1.0F - wa - wb;
      if (wa < 0.0F || wb < 0.0F || wc < 0.0F) continue;
      Corner mean;
      mean.normal =
          (wa * corners[0].normal + wb * corners[1].normal + wc * corners[2].normal).normalized();
      mean.weight = wa * corners[0].weight + wb * corners[1].weight + wc * corners[2].weight;
      column[u] = i;
      column[v] = j;
      add_column(column, axis, wa * a[axis] + wb * b[axis] + wc * c[axis], mean);
    }
  }
}

void SurfaceModel::add_column(const Cell& column, int axis, float surface, const Corner& mean) {
  const float slope = mean.normal[axis];
  const auto band = static_cast<float>(options_.band_voxels);
  const float reach = std::min(2.0F * band, band / std::max(0.1F, std::abs(slope)));
  Cell cell = column;
  Blocks::Block* block = nullptr;
  for (int k = ceil_int(surface - reach); k <= floor_int(surface + reach); ++k) {
    cell[axis] = k;
    if (block == nullptr || (k & (Blocks::kEdge - 1)) == 0) block = &voxels_.at(cell);
    observe(block->voxels[Blocks::index_in_block(cell)], (static_cast<float>(k) - surface) * slope,
            mean);
  }
}

void SurfaceModel::observe(Voxel& voxel, float distance, const Corner& from) {
  constexpr float kOtherSide = -0.5F;  // cosine of 120 deg
  const bool first = voxel.front.weight <= 0.0F;
  if (first) voxel.facing = PackedNormal(from.normal);
  const bool is_front = first || voxel.facing.unpacked().dot(from.normal) > kOtherSide;
  if (!is_front && voxel.back == 0) {
    backs_.emplace_back();
    voxel.back = static_cast<uint32_t>(backs_.size());
  }
  Side& side = is_front ? voxel.front : backs_[voxel.back - 1];
  // The weight falls off from half the band on behind the surface, where nothing was seen.
  const float depth = -distance / static_cast<float>(options_.band_voxels);
  const float trust = depth < 0.5F ? 1.0F : std::max(0.02F, 2.0F * (1.0F - depth));
  side.sum += trust * from.weight * distance;
  side.weight += trust * from.weight;
  count_up(voxel.seen);
}

float SurfaceModel::distance(const Voxel& voxel) const {
  const float front = voxel.front.sum / voxel.front.weight;
  if (voxel.back == 0) return front;
  const Side& back = backs_[voxel.back - 1];
  return std::max(front, back.sum / back.weight);  // solid is what lies behind both
}

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

void SurfaceModel::carve(const ScenePoints& scene, const FreeBeams& free) {
  const auto every = static_cast<std::size_t>(options_.carve_every);
  const auto per_m = static_cast<float>(1.0 / options_.voxel_m);
  std::size_t at = 0;
  for (std::size_t row = 0; row < scene.rows; row += every) {
    const Eigen::Vector3f& origin = scene.origins_m[row];
    for (std::size_t column = 0; column < scene.columns; column += every) {
      const uint16_t steps = free[at++];
      if (steps == 0) continue;
      const Eigen::Vector3f way = scene.points_m[scene.index(row, column)] - origin;
      voxels_.walk(origin * per_m, way / std::max(1e-6F, way.norm()),
                   static_cast<float>(steps) * kFreeStepM * per_m, [this](Voxel& voxel, float) {
                     if (known(voxel) && distance(voxel) < kSolid) count_up(voxel.through);
                   });
    }
  }
}

bool SurfaceModel::gone(const Cell& cell) const {
  int through = 0, seen = 0;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const Voxel* voxel = voxels_.find_voxel(cell + Cell(x, y, z));
        if (voxel == nullptr || !known(*voxel) || distance(*voxel) >= kSolid) continue;
        through += voxel->through;
        seen += voxel->seen;
      }
    }
  }
  return through >= 3 && through > options_.carve_ratio * seen;
}

TriangleMesh SurfaceModel::take_mesh() {
  TriangleMesh mesh = SurfaceNets(*this).run();
  backs_.clear();
  return mesh;
}

TriangleMesh fuse(const PlacedScenes& scenes, const SurfaceOptions& options) {
  const BeamNoise noise = learn_noise(scenes, options.smoothing);
  // Smoothed again for small pieces: all at once they would take most of the memory.
  const SmoothScenes smoothed{scenes.count, [&](std::size_t scene) {
                                return smooth(scenes.at(scene), noise, options.smoothing);
                              }};
  TriangleMesh mesh;
  {
    SurfaceModel model(options);
    std::vector<SurfaceModel::FreeBeams> free;
    for (std::size_t i = 0; i < smoothed.count; ++i) {
      const SmoothScene scene = smoothed.at(i);
      model.add(scene);
      free.push_back(model.free_beams(scene));
    }
    for (std::size_t i = 0; i < scenes.count; ++i) model.carve(scenes.at(i), free[i]);
    mesh = model.take_mesh();
  }
  malloc_trim(0);  // the voxels are small blocks, which the heap would keep for itself
  add_small_pieces(scenes, smoothed, options, mesh);
  return mesh;
}

}  // namespace marco::mapping3d
