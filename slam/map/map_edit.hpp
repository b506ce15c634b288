#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::slam {

/// What a person knows better than the mapper, for the next run on the same recording.
struct MapEdit {
  enum class Kind {
    forbid_loop,       ///< the places at both times are not the same: no loop joins them
    add_loop,          ///< they are, and `from_from_to` is how they lie to each other
    drop_scans,        ///< scans between both times are left out
    distrust_odometry  ///< between both times nothing is concluded from the odometry
  };

  Kind kind = Kind::forbid_loop;
  Utime from;
  Utime to;
  Pose2 from_from_to;  ///< of add_loop: the robot at `to`, seen from the robot at `from`
};
using MapEdits = std::vector<MapEdit>;

/// As parse_map_edits() reads it: `add_loop 12.500000 80.250000 1.2340 -0.5000 0.01570`, times in
/// seconds, metres and radians.
std::string to_line(const MapEdit& edit);

/// An edit a line; what follows a # and empty lines are left out.
/// @throws std::invalid_argument naming the line and what is wrong with it.
MapEdits parse_map_edits(std::string_view text);

/// Whether an edit of this kind covers that time.
bool is_covered(const MapEdits& edits, MapEdit::Kind kind, Utime utime);

/// How near in time the ends of a loop are to those of an edit that means it.
inline constexpr double kSameLoopS = 5.0;
bool forbids(const MapEdits& edits, Utime from, Utime to);

}  // namespace marco::slam
