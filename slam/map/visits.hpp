#pragma once

#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// Two keyframes of one place, taken at different times, and what they say of each other.
struct Visit {
  int older = 0;
  int newer = 0;
  int agreeing = 0;       ///< points of either that lie on the other's walls
  int contradicting = 0;  ///< points of either where the other saw free space

  int seen() const { return agreeing + contradicting; }
};

/// Compares each keyframe with older ones near to it, one for each stretch of path that passes, the
/// nearest first. What stands between both is not seen by both, and says nothing.
/// Cost O(keyframes * points).
std::vector<Visit> find_visits(const std::vector<Keyframe>& keys);

/// Two keyframes as they would see each other. The keys of the result are 0.
Visit compare(const Keyframe& older, const Keyframe& newer, const Pose2& older_from_newer);

/// Points of the `newer` keyframes where one of the `older` ones saw free space, world frame.
Points2 points_in_free_space(const std::vector<Keyframe>& keys,
                             const std::vector<int>& older,
                             const std::vector<int>& newer);

}  // namespace marco::slam
