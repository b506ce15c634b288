#pragma once

#include <vector>

#include "common/loop_closure.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// The loops that the pose graph did not find to contradict the rest, at their keyframes' present
/// poses. @param keys  each loop's ends are indices of these
LoopClosures loops_in_force(const std::vector<Loop>& loops, const std::vector<Keyframe>& keys);

}  // namespace marco::slam
