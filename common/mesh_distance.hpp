#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco {

/// Distances from points to a mesh, up to a limit: triangles in a hashed lattice of cells, so that
/// a query looks into one. Const members are safe from several threads.
class MeshDistance {
 public:
  /// @param mesh outlives this. @param max_m largest distance
  MeshDistance(const TriangleMesh& mesh, float max_m);

  /// @returns the distance, or `max_m` when it is farther.
  float operator()(const Eigen::Vector3f& point_m) const;
  /// Whether it is less than `max_m`: ends at the first triangle that is.
  bool any_within(const Eigen::Vector3f& point_m) const;
  float max_m() const { return max_m_; }

 private:
  static constexpr uint64_t kFree = ~uint64_t{0};
  /// A cell with triangles, in a hash table with open addressing.
  struct Slot {
    uint64_t key = kFree;
    std::size_t first = 0;  ///< in `triangles_`
    uint32_t count = 0;
  };

  template <class Visit>
  void for_each_cell_of(std::size_t triangle, const Visit& visit) const;
  void grow_slots();
  std::size_t slot_of(uint64_t key) const;
  std::span<const uint32_t> near(const Eigen::Vector3f& point_m) const;
  bool may_reach(uint32_t triangle, const Eigen::Vector3f& point_m, float within_m) const;
  float squared_m2(uint32_t triangle, const Eigen::Vector3f& point_m) const;
  Eigen::Vector3i cell_of(const Eigen::Vector3f& point_m) const;

  struct Ball {
    Eigen::Vector3f centre_m;
    float radius_m;
  };

  const TriangleMesh& mesh_;
  std::vector<Ball> balls_;  ///< about each triangle: most are too far away to look at their edges
  float max_m_;
  float cell_m_;
  std::vector<Slot> slots_;
  std::size_t cells_ = 0;
  std::vector<uint32_t> triangles_;  ///< cell by cell
};

struct MeshGap {
  std::size_t samples = 0;
  double rms_m = 0.0;
  double max_m = 0.0;
};

/// Distance of the surface of `from` to another mesh, sampled once per `area_each_m2` (small
/// triangles share samples). Distances are limited to the largest of `to`.
MeshGap gap(const TriangleMesh& from, const MeshDistance& to, float area_each_m2);

}  // namespace marco
