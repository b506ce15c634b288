#pragma once

#include <string>

#include "common/wall.hpp"

namespace marco::files {

/// The walls with every field: {"unit": "m", "walls": [{"id", "start_m": [x, y], "end_m",
/// "covariance_m2": 4 x 4 of (start x, y, end x, y), "existence", "times_seen", "start_seen",
/// "end_seen"}]}.
std::string lines_json(const Walls& walls);

}  // namespace marco::files
