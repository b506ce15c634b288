#pragma once

#include <string>

#include "common/line_map.hpp"

namespace marco::files {

/// The walls, posts and curved walls with every field: {"unit": "m", "walls": [{"id", "start_m":
/// [x, y], "end_m", "covariance_m2": 4 x 4 of (start x, y, end x, y), "existence", "times_seen",
/// "start_seen", "end_seen"}], "round_walls": [{"id", "centre_m", "radius_m", "covariance_m2": 3 x
/// 3 of (centre x, y, radius), "from_inside", "from_rad", "span_rad", "existence", "times_seen"}]}.
std::string lines_json(const LineMap& map);

}  // namespace marco::files
