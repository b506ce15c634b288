#pragma once

#include <vector>

#include "slam/line_slam/ekf/wall_map.hpp"

namespace marco::slam {

/// The association of one observed wall.
struct WallMatch {
  static constexpr int kNew = -1;      ///< resembles no wall of the map
  static constexpr int kUnclear = -2;  ///< resembles one, but fails a gate: not used
  int wall = kNew;                     ///< index of the map's wall
  double distance2 = 0.0;              ///< squared Mahalanobis distance of the pairing (2 degrees)
};

/// Data association (5.1): pairs observed walls with active walls of the map. "joint": candidates
/// within the widened limits of `similar` and the innovation gate, then JCBB, then a check from the
/// pose that the pairings imply. "similar": the thesis' rule by itself. @returns one match per
/// observed wall.
std::vector<WallMatch> associate_walls(const WallMap& map,
                                       const std::vector<ObservedWall>& observed);

}  // namespace marco::slam
