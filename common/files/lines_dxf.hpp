#pragma once

#include <string>

#include "common/wall.hpp"

namespace marco::files {

/// A plan for drawing programs: DXF R12, one LINE a wall on layer WALLS, metres, start to end (free
/// space on the left).
std::string lines_dxf(const Walls& walls);

}  // namespace marco::files
