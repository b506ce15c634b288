#pragma once

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Points with the way their surface faces.
struct OrientedPoints {
  Points2 points;  ///< 2xN [m]
  Points2
      normals;  ///< 2xN unit length, towards the sensor; (0, 0) where the neighbours make no line

  bool has_normal(Eigen::Index i) const { return normals(0, i) != 0.0 || normals(1, i) != 0.0; }
};

struct NormalOptions {
  int neighbours = 5;      ///< taken in on each side at most
  double radius_m = 0.25;  ///< a neighbour lies within this, or is the next beam's
  double gap_m =
      0.30;  ///< a larger step between neighbours is an edge, unless beams lie wider apart
  double gap_per_range = 0.10;  ///< the same as a part of the range, for far walls
  double max_rms_m = 0.03;      ///< of the neighbours about their line

  template <class Visitor>
  void visit(Visitor& v) {
    v("neighbours", neighbours, Limits{1, 50});
    v("radius_m", radius_m, kPositive);
    v("gap_m", gap_m, kPositive);
    v("gap_per_range", gap_per_range, kNotNegative);
    v("max_rms_m", max_rms_m, kPositive);
  }
};

/// Finds each point's normal from its neighbours in the sweep: principal components, as thesis B's
/// calculated points (app. E.20-30), with neighbours chosen by distance instead of by growing
/// error.
/// @param points  2xN [m] in the order of the beams
/// @param sensor  [m] where the beams came from, same frame
/// Cost O(N · neighbours).
OrientedPoints orient(const Points2& points,
                      const Eigen::Vector2d& sensor,
                      const NormalOptions& options);

}  // namespace marco::slam
