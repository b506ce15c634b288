#pragma once

#include <array>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/facets.hpp"
#include "mapping3d/surface/scene_smoothing.hpp"
#include "mapping3d/surface/voxel_blocks.hpp"

namespace marco::mapping3d {

struct SurfaceOptions {
  double voxel_m = 0.025;           ///< thinner plates seen from both sides are lost
  double band_voxels = 2.0;         ///< samples so near to a surface learn their distance to it
  double pose_sigma_deg = 0.10;     ///< of a scene: far surfaces count less,
  double pose_sigma_m = 0.002;      ///< and none is better than this
  double carve_margin_m = 0.05;     ///< a beam says `free` up to here before the plane it ends on
  int carve_every = 2;              ///< rows and columns of beams that vote
  double carve_ratio = 0.25;        ///< votes for each facet that was seen there: solid is gone
  double min_component_m2 = 0.025;  ///< smaller islands are mixed ranges
  SmoothingOptions smoothing;
  FacetOptions facets;

  template <class Visitor>
  void visit(Visitor& v) {
    v("voxel_m", voxel_m, Limits{0.005, 1.0});
    v("band_voxels", band_voxels, Limits{1.1, 8.0});
    v("pose_sigma_deg", pose_sigma_deg, kNotNegative);
    v("pose_sigma_m", pose_sigma_m, kPositive);
    v("carve_margin_m", carve_margin_m, kPositive);
    v("carve_every", carve_every, Limits{1, 16});
    v("carve_ratio", carve_ratio, kPositive);
    v("min_component_m2", min_component_m2, kNotNegative);
    v("smoothing", smoothing);
    v("facets", facets);
  }
};

/// One surface from many scenes: a signed distance in a sparse lattice (Curless and Levoy,
/// SIGGRAPH 1996), with four differences. A scene enters smoothed, as facets scan-converted along
/// the axis they face, with point-to-plane distances weighted by the noise across the surface
/// (incidence and range), so that gaps between beams are no holes. Surfaces that face each other's
/// backs keep distances of their own, so that a thin plate seen from both sides stays. Beams carve
/// by vote, at the end, so that the order of scenes does not matter. What no beam met stays
/// unknown, and the surface open there.
/// Deterministic; not thread-safe. Limits: +-2^23 voxels from the origin.
class SurfaceModel {
 public:
  explicit SurfaceModel(const SurfaceOptions& options = {});

  /// Merges a scene's surfaces, in the frame of its points.
  void add(const SmoothScene& scene);

  /// Counts where the scene's beams saw through what is claimed to be solid; after every `add`.
  void carve(const SmoothScene& scene);

  /// The surface: triangles counter-clockwise seen from where it was seen, with normals.
  TriangleMesh mesh() const;

  /// @returns how many blocks of 8 x 8 x 8 samples there are.
  std::size_t block_count() const { return voxels_.blocks().size(); }

 private:
  struct Side {
    float sum = 0.0F;
    float weight = 0.0F;
  };
  struct Voxel {
    Side front;  ///< surfaces that face as the first seen, within 120 deg
    Side back;
    std::array<int8_t, 3> facing{};  ///< of the first seen, times 127
    uint8_t seen = 0;                ///< scenes' facets
    uint8_t through = 0;             ///< beams
  };
  using Blocks = VoxelBlocks<Voxel>;
  /// In voxels: deeper than a beam may pass a surface by.
  static constexpr float kSolid = -0.5F;
  struct Corner {
    Eigen::Vector3f at;  ///< in voxels
    Eigen::Vector3f normal;
    float weight = 0.0F;
  };

  void rasterize(const std::array<Corner, 3>& corners);
  void add_column(const Cell& column, int axis, float surface, const Corner& mean);
  void observe(Voxel& voxel, float distance, const Corner& from) const;
  void carve_beam(const Eigen::Vector3f& origin, const Eigen::Vector3f& end, float cosine);
  static float distance(const Voxel& voxel);
  static bool known(const Voxel& voxel) {
    return voxel.front.weight > 0.0F || voxel.back.weight > 0.0F;
  }
  bool gone(const Cell& cell) const;

  friend class SurfaceNets;
  SurfaceOptions options_;
  Blocks voxels_;
};

/// All scenes' surface in one go: add, carve, mesh.
TriangleMesh fuse(const std::vector<ScenePoints>& scenes, const SurfaceOptions& options = {});

}  // namespace marco::mapping3d
