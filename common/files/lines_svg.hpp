#pragma once

#include <string>

#include "common/trajectory.hpp"
#include "common/wall.hpp"

namespace marco::files {

/// The walls and the path as a drawing (MetreSvg): walls green, paler the less likely they exist,
/// the path red.
std::string lines_svg(const Walls& walls, const Trajectory& path);

}  // namespace marco::files
