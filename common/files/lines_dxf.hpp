#pragma once

#include <string>

#include "common/wall.hpp"

namespace marco::files {

/// The walls for CAD programs: DXF R12, one LINE per wall on layer WALLS, in metres, from start to
/// end (free space on the left).
std::string lines_dxf(const Walls& walls);

}  // namespace marco::files
