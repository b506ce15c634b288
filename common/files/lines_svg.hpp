#pragma once

#include <string>

#include "common/trajectory.hpp"
#include "common/wall.hpp"

namespace marco::files {

/// A plan as an SVG picture: walls green, those not sure to stand paler, the path red, 1 m grid.
/// One unit is a metre, y up. Nothing to draw gives an empty picture of 1 m.
std::string lines_svg(const Walls& walls, const Trajectory& path);

}  // namespace marco::files
