#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace marco::files {

/// A floor plan as a drawing (MetreSvg). @param chains  of points [m]
std::string plan_svg(const std::vector<std::vector<Eigen::Vector2d>>& chains);

}  // namespace marco::files
