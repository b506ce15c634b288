#pragma once

#include <string>

#include "common/line_map.hpp"
#include "common/trajectory.hpp"

namespace marco::files {

/// The walls, posts and curved walls with every field: {"unit": "m", "walls": [{"id", "start_m":
/// [x, y], "end_m", "covariance_m2": 4 x 4 of (start x, y, end x, y), "existence", "times_seen",
/// "start_seen", "end_seen"}], "round_walls": [{"id", "centre_m", "radius_m", "covariance_m2": 3 x
/// 3 of (centre x, y, radius), "from_inside", "from_rad", "span_rad", "existence", "times_seen"}]}.
std::string lines_json(const LineMap& map);

/// Walls, posts and the path as a drawing (MetreSvg): walls and posts green, paler the less likely
/// they exist, corners blue squares, the path red.
std::string lines_svg(const LineMap& map, const Trajectory& path);

/// The walls for CAD programs: DXF R12, one LINE per wall on layer WALLS, in metres, from start to
/// end (free space on the left); an ARC per curved wall there, a CIRCLE per post on layer POSTS,
/// a POINT per corner on layer CORNERS.
std::string lines_dxf(const LineMap& map);

}  // namespace marco::files
