#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace marco::files {

/// A floor plan as a drawing: chains of points [m], x to the right, y up, 40 px a metre, a metre
/// grid behind.
std::string plan_svg(const std::vector<std::vector<Eigen::Vector2d>>& chains);

}  // namespace marco::files
