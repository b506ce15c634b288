#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/facets.hpp"
#include "mapping3d/surface/scene_smoothing.hpp"
#include "mapping3d/surface/voxel_blocks.hpp"

namespace marco::mapping3d {

/// A direction in two bytes, to about a degree: its place on an octahedron, unfolded into a square
/// (Meyer and others, On floating-point normal vectors, 2010).
class PackedNormal {
 public:
  PackedNormal() = default;
  /// @param direction  of any length; of none becomes the z axis
  explicit PackedNormal(const Eigen::Vector3f& direction) {
    const float length = direction.cwiseAbs().sum();
    if (!(length > 0.0F)) return;
    const Eigen::Vector3f n = direction / length;
    const float u = n.z() >= 0.0F ? n.x() : folded(n.y(), n.x());
    const float v = n.z() >= 0.0F ? n.y() : folded(n.x(), n.y());
    u_ = static_cast<int8_t>(std::lround(kSteps * u));
    v_ = static_cast<int8_t>(std::lround(kSteps * v));
  }

  /// Unit length.
  Eigen::Vector3f unpacked() const {
    const float u = static_cast<float>(u_) / kSteps, v = static_cast<float>(v_) / kSteps;
    const float z = 1.0F - std::abs(u) - std::abs(v);
    const Eigen::Vector3f n =
        z >= 0.0F ? Eigen::Vector3f(u, v, z) : Eigen::Vector3f(folded(v, u), folded(u, v), z);
    return n.normalized();
  }

 private:
  static constexpr float kSteps = 127.0F;  // of a signed byte
  static float folded(float other, float own) { return std::copysign(1.0F - std::abs(other), own); }

  int8_t u_ = 0, v_ = 0;
};

struct SurfaceOptions {
  double voxel_m = 0.025;        ///< edge of a voxel; thinner plates seen from both sides are lost
  double band_voxels = 2.0;      ///< truncation distance
  double pose_sigma_deg = 0.10;  ///< of a scene's pose: distant surfaces weigh less
  double pose_sigma_m = 0.002;   ///< of a scene's pose: a floor of every weight
  double carve_margin_m = 0.05;  ///< a beam votes for free space up to here before its end
  int carve_every = 2;           ///< every nth row and column of beams votes
  double carve_ratio = 0.25;     ///< votes per observed facet that remove a solid voxel
  double min_component_m2 = 0.005;  ///< smaller components are mixed ranges
  SmoothingOptions smoothing;
  FacetOptions facets;

  template <class Visitor>
  void visit(Visitor& v) {
    v("voxel_m", voxel_m, Limits{0.005, 1.0},
      "Voxel size of the fused model. Less for fine detail: memory and time grow with the square. "
      "Thinner plates seen from both sides are lost.");
    v.advanced("carve_ratio", carve_ratio, kPositive,
               "Votes of free space per observed facet that remove a voxel. Less to remove what "
               "moved while it was scanned.");
    v.advanced("min_component_m2", min_component_m2, kNotNegative,
               "Smaller pieces of surface are removed as mixed ranges. Less for thin things.");
  }
};

/// Fusion of scenes into a truncated signed distance field (TSDF) of sparse voxels (Curless and
/// Levoy, SIGGRAPH 1996), with four differences. A scene is smoothed first and enters as facets,
/// scan converted along their main axis, with point-to-plane distances weighted by the noise across
/// the surface (incidence and range), so that gaps between beams do not become holes. A voxel keeps
/// a second distance for surfaces facing the other way, so that a thin plate seen from both sides
/// is preserved. Free space is carved by votes of the beams, after all scenes, so that their order
/// does not matter; a beam that goes through the middle of a wall was reflected, and what it
/// measured is taken out again. Unseen space stays unknown, and the surface open there.
/// Deterministic; not thread-safe. Limits: +-2^23 voxels from the origin.
class SurfaceModel {
 public:
  explicit SurfaceModel(const SurfaceOptions& options = {});

  /// Adds a scene, in the frame of its points.
  void add(const SmoothScene& scene) { enter(scene, Entry::add); }
  /// Takes out what `add` of the same scene put in.
  void remove(const SmoothScene& scene) { enter(scene, Entry::remove); }

  /// How far every nth row and column of beams sees free space, in steps of 2 mm; 0 = no return.
  using FreeBeams = std::vector<uint16_t>;
  FreeBeams free_beams(const SmoothScene& scene) const;
  /// Counts the scene's beams through solid voxels; to be called after every `add`.
  /// @param scene  as it was measured
  /// @param free  of the same scene, smoothed
  /// @returns the beams, as `free` counts them, that went on behind such a voxel; none if few did
  std::vector<uint32_t> carve(const ScenePoints& scene, const FreeBeams& free);
  /// Which of the beams that `carve` returned of this scene went through the middle of a wall where
  /// nearly all others end: mirrors, glass or polished metal sent them elsewhere. None if they are
  /// few. To be called after every `carve`.
  std::vector<uint32_t> reflected(const ScenePoints& scene,
                                  const FreeBeams& free,
                                  const std::vector<uint32_t>& passed) const;
  /// Takes the returns of these beams out of their scene, and those between them and the next ones.
  static void leave_out(const std::vector<uint32_t>& beams,
                        const SurfaceOptions& options,
                        SmoothScene& scene);

  /// The surface with normals; triangles are counter-clockwise from the free side. Leaves the model
  /// empty: the voxels of a building and what the surface is found in would not fit into memory
  /// together.
  TriangleMesh take_mesh();

  /// @returns how many blocks of 8 x 8 x 8 samples there are.
  std::size_t block_count() const { return voxels_.blocks().size(); }

 private:
  struct Side {
    float sum = 0.0F;
    float weight = 0.0F;
  };
  struct Voxel {
    Side front;           ///< surfaces within 120 deg of the first one's normal
    uint32_t back = 0;    ///< 1 more than the index in `backs_`; 0 = none: few surfaces are so thin
    PackedNormal facing;  ///< normal of the first one
    uint8_t seen = 0;     ///< number of facets
    uint8_t through = 0;  ///< number of beams through it
  };
  static_assert(sizeof(Voxel) == 16);
  using Blocks = VoxelBlocks<Voxel>;
  /// In voxels; a beam that passes a surface closely does not get deeper.
  static constexpr float kSolid = -0.5F;
  struct Corner {
    Eigen::Vector3f at;  ///< in voxels
    Eigen::Vector3f normal;
    float weight = 0.0F;
  };

  static constexpr uint8_t kMostCounted = 255;
  static void count_up(uint8_t& counter) {
    if (counter < kMostCounted) ++counter;
  }
  enum class Entry { add, remove };
  void enter(const SmoothScene& scene, Entry entry);
  void rasterize(const std::array<Corner, 3>& corners, Entry entry);
  void enter_column(const Cell& column, int axis, float surface, const Corner& mean, Entry entry);
  void observe(Voxel& voxel, float distance, const Corner& from);
  void forget(Voxel& voxel, float distance, const Corner& from);
  /// Of an observation at this distance; it falls off from half the band on behind the surface,
  /// where nothing was seen.
  float weight(float distance, const Corner& from) const;
  float distance(const Voxel& voxel) const;
  static bool known(const Voxel& voxel) { return voxel.front.weight > 0.0F; }
  struct Votes {
    int through = 0, seen = 0;
  };
  Votes votes_about(const Cell& cell) const;
  bool gone(const Cell& cell) const;
  bool is_wall(const Cell& cell, const Voxel& voxel) const;
  /// Calls visit(voxel, at, on) for the solid voxels on the free part of a beam: the place, and the
  /// length of the free part behind it, in voxels.
  template <class Visit>
  void follow(const ScenePoints& scene,
              const FreeBeams& free,
              std::size_t beam,
              const Visit& visit) const;

  friend class SurfaceNets;
  SurfaceOptions options_;
  Blocks voxels_;
  std::deque<Side> backs_;
};

/// The fused surface of all scenes: smooth, add, carve, mesh, and what is smaller than a voxel. No
/// two vertices are at one place.
/// @param scenes  each is asked for up to five times, one at a time
TriangleMesh fuse(const PlacedScenes& scenes, const SurfaceOptions& options = {});
inline TriangleMesh fuse(const std::vector<ScenePoints>& scenes,
                         const SurfaceOptions& options = {}) {
  return fuse(PlacedScenes::of(scenes), options);
}

}  // namespace marco::mapping3d
