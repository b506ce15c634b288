#pragma once

#include <string>

#include "common/line_map.hpp"

namespace marco::files {

/// The walls for CAD programs: DXF R12, one LINE per wall on layer WALLS, in metres, from start to
/// end (free space on the left); an ARC per curved wall there, a CIRCLE per post on layer POSTS,
/// a POINT per corner on layer CORNERS.
std::string lines_dxf(const LineMap& map);

}  // namespace marco::files
