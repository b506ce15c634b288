#include "mapping3d/surface/surface_nets.hpp"

#include <malloc.h>

#include <Eigen/Geometry>
#include <cmath>

#include "mapping3d/surface/islands.hpp"

namespace marco::mapping3d {
namespace {

Cell step(int axis) { return Cell(axis == 0, axis == 1, axis == 2); }

float area(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t) {
  const auto& v = mesh.vertices_m;
  return 0.5F * (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm();
}

}  // namespace

TriangleMesh SurfaceNets::run() {
  take_samples();
  // Vertices may lie in new blocks, which nothing crosses.
  const std::size_t blocks = samples_.blocks().size();
  for (std::size_t i = 0; i < blocks; ++i) cross_block(*samples_.blocks()[i]);
  samples_.take_blocks();
  malloc_trim(0);  // the heap would keep small blocks for itself
  finish_vertices();
  drop_islands();
  return std::move(mesh_);
}

void SurfaceNets::take_samples() {
  std::vector<Cell> freed;
  for (const auto& block : model_.voxels_.blocks()) {
    for (int i = 0; i < 512; ++i) {
      const SurfaceModel::Voxel& voxel = block->voxels[static_cast<std::size_t>(i)];
      if (!SurfaceModel::known(voxel) || voxel.through == 0) continue;
      const Cell cell = block->corner + Cell(i & 7, (i >> 3) & 7, i >> 6);
      if (model_.gone(cell)) freed.push_back(cell);
    }
  }
  // Block by block, so that what is freed makes room for what is made.
  for (std::unique_ptr<SurfaceModel::Blocks::Block>& from : model_.voxels_.take_blocks()) {
    Samples::Block& to = samples_.at(from->corner);
    for (std::size_t i = 0; i < 512; ++i) {
      const SurfaceModel::Voxel& voxel = from->voxels[i];
      if (!SurfaceModel::known(voxel)) continue;
      to.voxels[i] = {model_.distance(voxel), 0, voxel.facing, voxel.back != 0};
    }
    from.reset();
  }
  model_.backs_.clear();
  for (const Cell& cell : freed) set_free(cell);
}

// With it what lies just below its surface, where beams have no vote.
void SurfaceNets::set_free(const Cell& cell) {
  constexpr float kFreed = 0.5F;  // above 0: outside
  samples_.find_voxel(cell)->distance = kFreed;
  for (int i = 0; i < 27; ++i) {
    Sample* near = samples_.find_voxel(cell + Cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    if (near == nullptr || !(near->distance < 0.0F)) continue;
    if (near->distance >= SurfaceModel::kSolid) near->distance = kFreed;
  }
}

void SurfaceNets::cross_block(const Samples::Block& block) {
  constexpr std::array<std::size_t, 3> kStride{1, 8, 64};
  for (int axis = 0; axis < 3; ++axis) {
    const Samples::Block* after = samples_.find(block.corner + Samples::kEdge * step(axis));
    for (std::size_t i = 0; i < 512; ++i) {
      const float from = block.voxels[i].distance;
      if (std::isnan(from)) continue;
      const Cell local(static_cast<int>(i & 7U), static_cast<int>(i >> 3U & 7U),
                       static_cast<int>(i >> 6U));
      const std::size_t stride = kStride[static_cast<std::size_t>(axis)];
      const bool last = local[axis] == Samples::kEdge - 1;
      if (last && after == nullptr) continue;
      const float to = (last ? after->voxels[i - 7 * stride] : block.voxels[i + stride]).distance;
      if (std::isnan(to) || (from < 0.0F) == (to < 0.0F)) continue;
      cross(block.corner + local, axis, from, to);
    }
  }
}

// Whether the surface was seen from this side. Behind a wall's band the distance jumps to that of
// another surface; this step is no surface.
bool SurfaceNets::seen_from(const Cell& cell, int axis, bool outwards) const {
  const Sample* sample = samples_.find_voxel(cell);
  if (sample == nullptr || sample->of_both_sides) return true;
  const float along = sample->facing.unpacked()[axis];
  return (outwards ? along : -along) > -0.4F;
}

void SurfaceNets::cross(const Cell& cell, int axis, float from, float to) {
  const bool outwards = to >= 0.0F;  // towards the axis
  if (!seen_from(cell, axis, outwards) || !seen_from(cell + step(axis), axis, outwards)) return;
  Eigen::Vector3f at = cell.cast<float>();
  at[axis] += from / (from - to);
  const Cell u = step((axis + 1) % 3), v = step((axis + 2) % 3);
  add_quad({vertex(cell - u - v, at), vertex(cell - v, at), vertex(cell, at), vertex(cell - u, at)},
           !outwards);
}

uint32_t SurfaceNets::vertex(const Cell& cell, const Eigen::Vector3f& crossing) {
  uint32_t& entry = samples_.voxel(cell).vertex;
  if (entry == 0) {
    mesh_.vertices_m.emplace_back(Eigen::Vector3f::Zero());
    crossings_.push_back(0.0F);
    entry = static_cast<uint32_t>(mesh_.vertices_m.size());
  }
  mesh_.vertices_m[entry - 1] += crossing;
  crossings_[entry - 1] += 1.0F;
  return entry - 1;
}

void SurfaceNets::add_quad(std::array<uint32_t, 4> corners, bool flipped) {
  if (flipped) std::swap(corners[1], corners[3]);
  quads_.push_back(corners);
}

void SurfaceNets::finish_vertices() {
  const auto voxel_m = static_cast<float>(model_.options_.voxel_m);
  for (std::size_t i = 0; i < crossings_.size(); ++i)
    mesh_.vertices_m[i] *= voxel_m / crossings_[i];
  const auto& p = mesh_.vertices_m;
  for (const auto& q : quads_) {
    if ((p[q[0]] - p[q[2]]).squaredNorm() <= (p[q[1]] - p[q[3]]).squaredNorm()) {
      mesh_.triangles.push_back({q[0], q[1], q[2]});
      mesh_.triangles.push_back({q[0], q[2], q[3]});
    } else {
      mesh_.triangles.push_back({q[0], q[1], q[3]});
      mesh_.triangles.push_back({q[1], q[2], q[3]});
    }
  }
}

// And vertices of nothing, and the normals.
void SurfaceNets::drop_islands() {
  Islands islands(mesh_.vertices_m.size());
  for (const auto& t : mesh_.triangles) {
    islands.join(t[0], t[1]);
    islands.join(t[1], t[2]);
  }
  std::vector<float> areas_m2(mesh_.vertices_m.size(), 0.0F);
  for (const auto& t : mesh_.triangles) areas_m2[islands.root(t[0])] += area(mesh_, t);
  TriangleMesh kept;
  std::vector<uint32_t> moved_to(mesh_.vertices_m.size(), 0);
  for (const auto& t : mesh_.triangles) {
    if (static_cast<double>(areas_m2[islands.root(t[0])]) < model_.options_.min_component_m2) {
      continue;
    }
    std::array<uint32_t, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      uint32_t& to = moved_to[t[i]];
      if (to == 0) {
        kept.vertices_m.push_back(mesh_.vertices_m[t[i]]);
        kept.normals.emplace_back(Eigen::Vector3f::Zero());
        to = static_cast<uint32_t>(kept.vertices_m.size());
      }
      triangle[i] = to - 1;
    }
    const auto& v = kept.vertices_m;
    const Eigen::Vector3f normal =
        (v[triangle[1]] - v[triangle[0]]).cross(v[triangle[2]] - v[triangle[0]]);
    if (!(normal.squaredNorm() > 0.0F)) continue;
    for (const uint32_t corner : triangle) kept.normals[corner] += normal;
    kept.triangles.push_back(triangle);
  }
  for (Eigen::Vector3f& normal : kept.normals) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
  kept.vertices_m.shrink_to_fit();
  kept.normals.shrink_to_fit();
  kept.triangles.shrink_to_fit();
  mesh_ = std::move(kept);
}

}  // namespace marco::mapping3d
