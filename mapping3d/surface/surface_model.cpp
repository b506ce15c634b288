#include "mapping3d/surface/surface_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/pose2.hpp"
#include "mapping3d/surface/small_pieces.hpp"
#include "mapping3d/surface/surface_nets.hpp"
#include "mapping3d/surface/welded.hpp"

namespace marco::mapping3d {
namespace {

int floor_int(float value) { return static_cast<int>(std::floor(value)); }
int ceil_int(float value) { return static_cast<int>(std::ceil(value)); }

constexpr float kOtherSide = -0.5F;  // cosine of 120 deg

}  // namespace

SurfaceModel::SurfaceModel(const SurfaceOptions& options) : options_(options) {
  validate(options, "surface");
}

void SurfaceModel::enter(const SmoothScene& scene, Entry entry) {
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
    rasterize(facet, entry);
  }
}

// Scan conversion along the facet's main axis: each lattice line meets the facet at most once, and
// neighbouring facets neither share nor miss a line.
void SurfaceModel::rasterize(const std::array<Corner, 3>& corners, Entry entry) {
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
      enter_column(column, axis, wa * a[axis] + wb * b[axis] + wc * c[axis], mean, entry);
    }
  }
}

void SurfaceModel::enter_column(
    const Cell& column, int axis, float surface, const Corner& mean, Entry entry) {
  const float slope = mean.normal[axis];
  const auto band = static_cast<float>(options_.band_voxels);
  const float reach = std::min(2.0F * band, band / std::max(0.1F, std::abs(slope)));
  Cell cell = column;
  Blocks::Block* block = nullptr;
  for (int k = ceil_int(surface - reach); k <= floor_int(surface + reach); ++k) {
    cell[axis] = k;
    if (block == nullptr || (k & (Blocks::kEdge - 1)) == 0) block = &voxels_.at(cell);
    Voxel& voxel = block->voxels[Blocks::index_in_block(cell)];
    const float distance = (static_cast<float>(k) - surface) * slope;
    if (entry == Entry::add) {
      observe(voxel, distance, mean);
    } else {
      forget(voxel, distance, mean);
    }
  }
}

float SurfaceModel::weight(float distance, const Corner& from) const {
  const float depth = -distance / static_cast<float>(options_.band_voxels);
  const float trust = depth < 0.5F ? 1.0F : std::max(0.02F, 2.0F * (1.0F - depth));
  return trust * from.weight;
}

void SurfaceModel::observe(Voxel& voxel, float distance, const Corner& from) {
  const bool first = voxel.front.weight <= 0.0F;
  if (first) voxel.facing = PackedNormal(from.normal);
  const bool is_front = first || voxel.facing.unpacked().dot(from.normal) > kOtherSide;
  if (!is_front && voxel.back == 0) {
    backs_.emplace_back();
    voxel.back = static_cast<uint32_t>(backs_.size());
  }
  Side& side = is_front ? voxel.front : backs_[voxel.back - 1];
  const float weight = this->weight(distance, from);
  side.sum += weight * distance;
  side.weight += weight;
  count_up(voxel.seen);
}

void SurfaceModel::forget(Voxel& voxel, float distance, const Corner& from) {
  if (voxel.seen == 0) return;
  const bool is_front = voxel.facing.unpacked().dot(from.normal) > kOtherSide;
  if (!is_front && voxel.back == 0) return;
  Side& side = is_front ? voxel.front : backs_[voxel.back - 1];
  const float weight = this->weight(distance, from);
  side.sum -= weight * distance;
  side.weight -= weight;
  if (voxel.seen < kMostCounted) --voxel.seen;  // beyond it nobody knows how many there were
  // What rounding leaves is no surface.
  constexpr float kRounding = 1e-3F;
  if (side.weight > kRounding * weight) return;
  if (is_front) {
    voxel = {};
  } else {
    side = {};
  }
}

float SurfaceModel::distance(const Voxel& voxel) const {
  const float front = voxel.front.sum / voxel.front.weight;
  if (voxel.back == 0) return front;
  const Side& back = backs_[voxel.back - 1];
  if (back.weight <= 0.0F) return front;           // it was taken out again
  return std::max(front, back.sum / back.weight);  // solid is what lies behind both
}

TriangleMesh SurfaceModel::take_mesh() { return SurfaceNets(*this).run(); }

TriangleMesh fuse(const PlacedScenes& scenes, const SurfaceOptions& options) {
  const BeamNoise noise = learn_noise(scenes, options.smoothing);
  std::vector<std::vector<uint32_t>> reflected(scenes.count);  // beams; known after carving
  // Smoothed again for small pieces: all at once they would take most of the memory.
  const SmoothScenes smoothed{scenes.count, [&](std::size_t i) {
                                SmoothScene scene = smooth(scenes.at(i), noise, options.smoothing);
                                SurfaceModel::leave_out(reflected[i], options, scene);
                                return scene;
                              }};
  SurfaceModel model(options);
  std::vector<SurfaceModel::FreeBeams> free;
  for (std::size_t i = 0; i < smoothed.count; ++i) {
    const SmoothScene scene = smoothed.at(i);
    model.add(scene);
    free.push_back(model.free_beams(scene));
  }
  std::vector<std::vector<uint32_t>> passed;
  for (std::size_t i = 0; i < scenes.count; ++i) {
    passed.push_back(model.carve(scenes.at(i), free[i]));
  }
  for (std::size_t i = 0; i < scenes.count; ++i) {
    if (passed[i].empty()) continue;
    reflected[i] = model.reflected(scenes.at(i), free[i], passed[i]);
  }
  free = {};
  for (std::size_t i = 0; i < scenes.count; ++i) {
    if (reflected[i].empty()) continue;
    SmoothScene scene = smooth(scenes.at(i), noise, options.smoothing);
    model.remove(scene);
    SurfaceModel::leave_out(reflected[i], options, scene);
    model.add(scene);
  }
  TriangleMesh mesh = model.take_mesh();
  add_small_pieces(scenes, smoothed, options, mesh);
  if (std::optional<TriangleMesh> one = welded(mesh)) mesh = std::move(*one);
  return mesh;
}

}  // namespace marco::mapping3d
