#pragma once

#include <array>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/scene_smoothing.hpp"

namespace marco::mapping3d {

struct FacetOptions {
  double plane_gap_m = 0.015;     ///< beams share a plane when each lies this near the other's ...
  double plane_gap_share = 0.04;  ///< ... plus this part of their distance and their noise
  double max_edge_m = 0.8;        ///< longest edge between beams of one plane
  double corner_factor = 1.5;  ///< longest edge across a corner, times the beams' distance (50 deg)
  double corner_floor_m = 0.02;  ///< added to it
  double max_corner_m = 0.2;     ///< its limit: the edge cuts a corner by a third of its length
  double loose_factor = 1.5;     ///< the same where a beam is on no plane (50 deg)
  double loose_floor_m = 0.01;   ///< added to it
  double max_loose_m = 0.4;      ///< its limit; a corner may be missed, but not what is far away

  template <class Visitor>
  void visit(Visitor& v) {
    v("plane_gap_m", plane_gap_m, kPositive);
    v("plane_gap_share", plane_gap_share, kNotNegative);
    v("max_edge_m", max_edge_m, kPositive);
    v("corner_factor", corner_factor, kPositive);
    v("corner_floor_m", corner_floor_m, kNotNegative);
    v("max_corner_m", max_corner_m, kPositive);
    v("loose_factor", loose_factor, kNotNegative);
    v("loose_floor_m", loose_floor_m, kNotNegative);
    v("max_loose_m", max_loose_m, kPositive);
  }
};

/// Triangles between neighbouring beams of one surface, as indices row * columns + column,
/// counter-clockwise seen from the sensor. Long edges need the same plane at both ends, so that a
/// distant floor is closed but a depth edge is not bridged.
std::vector<std::array<uint32_t, 3>> facets(const SmoothScene& scene,
                                            const FacetOptions& options = {});

}  // namespace marco::mapping3d
