#pragma once

#include <Eigen/Core>
#include <vector>

#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// Surfaces as a tree of parts, each with coarser and coarser triangles of the same vertices
/// (quadric collapse; libmeshoptimizer). Parts keep their rims, so that neighbours of different
/// levels meet; the larger part that two make together is spared the rim between them.
class DetailLevels {
 public:
  explicit DetailLevels(const Geometry& surfaces);

  /// Of all parts and levels, one after another.
  const std::vector<uint32_t>& indices() const { return indices_; }

  struct Range {
    std::size_t first = 0;  ///< of `indices()`
    std::size_t count = 0;
  };
  /// The same triangles with vertices of each level's own, in the order they are used: a software
  /// driver that keeps the last few hundred of them shades each of them hardly more than once.
  /// @param surfaces  what the levels were made of
  Geometry packed(const Geometry& surfaces) const;
  struct View {
    Eigen::Matrix4d clip_from_world;
    Eigen::Vector3d eye_m;
    double px_per_m = 1.0;    ///< of what lies at 1 m in front of the eye, or anywhere
    bool perspective = true;  ///< else anywhere
    double allowed_px = 1.0;
  };
  /// What to draw, from front to back: of the parts that may lie in the picture those, and at those
  /// levels, that take the fewest triangles while no error looks larger than `allowed_px`.
  std::vector<Range> choose(const View& view) const;

 private:
  static constexpr int kNone = -1;
  struct Level {
    Range range;
    std::size_t step = 0;  ///< of the errors that levels are made for; 0: every triangle
    double error_m = 0.0;
  };
  struct Part {
    Eigen::Vector3d low_m, high_m;
    std::vector<Level> levels;  ///< finest first; a part of parts need not have any
    int first = kNone, second = kNone;
  };
  class Builder;
  struct Choice;
  Choice choose(const View& view, int part) const;

  std::vector<uint32_t> indices_;
  std::vector<Part> parts_;  ///< the last is the whole
};

}  // namespace marco::viewer
