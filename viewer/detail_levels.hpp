#pragma once

#include <Eigen/Core>
#include <vector>

#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// Level of detail: surfaces as a tree of parts, each with several triangulations of the same
/// vertices (quadric collapse; libmeshoptimizer), and how far each is from the surface, measured.
/// Parts keep their borders, so that neighbours of different levels meet; a parent need not keep
/// the border between its two children.
class DetailLevels {
 public:
  explicit DetailLevels(const Geometry& surfaces);

  /// Of all parts and levels, one after another.
  const std::vector<uint32_t>& indices() const { return indices_; }

  struct Range {
    std::size_t first = 0;  ///< of `indices()`
    std::size_t count = 0;
  };
  /// The same triangles, with separate vertices per level in the order of their use: a software
  /// driver that caches the last few hundred shades each of them about once.
  /// @param surfaces  what the levels were made of
  Geometry packed(const Geometry& surfaces) const;
  struct View {
    Eigen::Matrix4d clip_from_world;
    Eigen::Vector3d eye_m;
    double px_per_m = 1.0;  ///< at 1 m in front of the eye; orthographic: anywhere
    bool perspective = true;
    double allowed_px = 1.0;
  };
  /// What to draw, from front to back: the visible parts, at the levels with the fewest triangles
  /// whose error in the picture is at most `allowed_px`.
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
