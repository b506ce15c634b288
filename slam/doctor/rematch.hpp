#pragma once

#include <optional>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// A pose that lays one stretch of path on another better than the map does.
struct Rematch {
  Pose2 older_from_newer;  ///< of the two keyframes
  double shift_m = 0.0;    ///< from where the map has the newer one
  double turn_rad = 0.0;
  double overlap = 0.0;         ///< part of the newer points on the older walls there, 0..1
  double overlap_before = 0.0;  ///< the same where the map has them
};

/// Matches the keyframes around `newer` against those around `older` once more, wherever they may
/// lie within 2 m and 20 deg of where the map has them.
/// @returns nothing where no other pose is clearly better: what contradicts has moved, is in a
/// wrong place altogether, or the two do not show the same walls.
std::optional<Rematch> match_again(const std::vector<Keyframe>& keys, int older, int newer);

}  // namespace marco::slam
