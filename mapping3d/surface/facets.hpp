#pragma once

#include <array>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/surface/scene_smoothing.hpp"

namespace marco::mapping3d {

struct FacetOptions {
  double plane_gap_m = 0.015;  ///< beams lie on one plane when each is so near to the other's ...
  double plane_gap_share = 0.04;  ///< ... plus this share of their distance,
  double max_edge_m = 0.8;        ///< and are then joined up to here
  double corner_factor = 1.5;     ///< across a corner: so many times the beams' distance (50 deg)
  double corner_floor_m = 0.02;   ///< and this much more,
  double max_corner_m = 0.2;      ///< but up to here: the cut across a corner is a third of it off
  double loose_factor = 1.5;      ///< or so many times where one of them is on no plane (50 deg)
  double loose_floor_m = 0.01;    ///< and this much more

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
  }
};

/// The triangles between neighbouring beams that see one surface, as indices row * columns +
/// column, counter-clockwise seen from the sensor. Long ones only where both ends agree on the
/// plane: a floor far away is whole, and no skin hangs from an edge in front.
std::vector<std::array<uint32_t, 3>> facets(const SmoothScene& scene,
                                            const FacetOptions& options = {});

}  // namespace marco::mapping3d
