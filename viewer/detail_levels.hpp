#pragma once

#include <Eigen/Core>
#include <vector>

#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// Surfaces in parts of some metres, each with coarser and coarser triangles of the same vertices
/// (quadric collapse; libmeshoptimizer). Parts keep their rims, so that neighbours of different
/// levels meet.
class DetailLevels {
 public:
  explicit DetailLevels(const Geometry& surfaces);

  /// Of all parts and levels, one after another.
  const std::vector<uint32_t>& indices() const { return indices_; }

  struct Range {
    std::size_t first = 0;  ///< of `indices()`
    std::size_t count = 0;
  };
  /// What to draw: parts that may lie in the picture, each at the coarsest level whose error looks
  /// no larger than `allowed_px`.
  /// @param px_per_m of what lies at 1 m in front of the eye, or anywhere when not `perspective`
  std::vector<Range> choose(const Eigen::Matrix4d& clip_from_world,
                            const Eigen::Vector3d& eye_m,
                            double px_per_m,
                            bool perspective,
                            double allowed_px) const;

 private:
  struct Level {
    Range range;
    double error_m = 0.0;
  };
  struct Part {
    Eigen::Vector3d low_m, high_m;
    std::vector<Level> levels;  ///< finest first
  };
  void add_part(const Geometry& surfaces, std::vector<uint32_t> triangles);

  std::vector<uint32_t> indices_;
  std::vector<Part> parts_;
};

}  // namespace marco::viewer
