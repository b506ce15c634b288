#pragma once

#include <vector>

#include "plan/known_plan/plan_sight.hpp"
#include "plan/surfels.hpp"

namespace marco::plan {

/// How a drawn curve deviates from what was measured of it.
struct CurveFit {
  bool found = false;                ///< enough of it was seen
  double off_m = 0.0;                ///< along the drawn normals
  double sigma_m = 0.0;              ///< of that, by the points alone
  Eigen::Vector2d shift_m = {0, 0};  ///< of its centre; near 0 along what a short arc cannot show
  double seen_m = 0.0;               ///< of its length
};

/// Least squares of the points that lie within 25 cm of the curve and face its way, with a kernel
/// that narrows to 3 cm (Geman and McClure): off + normal . shift for each.
/// @param chords  of one curve. @param surfels  in the drawing's frame
CurveFit fit_curve(const std::vector<DrawnFace>& chords, const std::vector<PlanSurfel>& surfels);

}  // namespace marco::plan
