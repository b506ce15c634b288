#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace marco {

/// The polyline without points that lie within `tolerance` of what is left (Ramer 1972; Douglas and
/// Peucker 1973). First and last point stay; nothing for nothing. Any unit.
std::vector<Eigen::Vector2d> simplify_polyline(std::span<const Eigen::Vector2d> points,
                                               double tolerance);

}  // namespace marco
