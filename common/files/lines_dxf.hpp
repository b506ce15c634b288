#pragma once

#include <string>

#include "common/round_wall.hpp"
#include "common/wall.hpp"

namespace marco::files {

/// The walls for CAD programs: DXF R12, one LINE per wall on layer WALLS, in metres, from start to
/// end (free space on the left); an ARC per curved wall there, a CIRCLE per post on layer POSTS.
std::string lines_dxf(const Walls& walls, const RoundWalls& round_walls);

}  // namespace marco::files
