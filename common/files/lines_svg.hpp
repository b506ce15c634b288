#pragma once

#include <string>

#include "common/round_wall.hpp"
#include "common/trajectory.hpp"
#include "common/wall.hpp"

namespace marco::files {

/// Walls, posts and the path as a drawing (MetreSvg): walls and posts green, paler the less likely
/// they exist, the path red.
std::string lines_svg(const Walls& walls, const RoundWalls& round_walls, const Trajectory& path);

}  // namespace marco::files
