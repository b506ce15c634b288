#pragma once

#include <string>

#include "common/line_map.hpp"
#include "common/trajectory.hpp"

namespace marco::files {

/// Walls, posts and the path as a drawing (MetreSvg): walls and posts green, paler the less likely
/// they exist, corners blue squares, the path red.
std::string lines_svg(const LineMap& map, const Trajectory& path);

}  // namespace marco::files
