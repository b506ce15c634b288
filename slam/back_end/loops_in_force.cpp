#include "slam/back_end/loops_in_force.hpp"

#include <cmath>

namespace marco::slam {

LoopClosures loops_in_force(const std::vector<Loop>& loops, const std::vector<Keyframe>& keys) {
  LoopClosures closures;
  closures.reserve(loops.size());
  for (const Loop& loop : loops) {
    if (!loop.is_inlier) continue;
    const Keyframe& from = keys[static_cast<std::size_t>(loop.from)];
    const Keyframe& to = keys[static_cast<std::size_t>(loop.to)];
    const Pose2 seen_from_now =
        between(loop.from_from_to, between(from.world_from_robot, to.world_from_robot));
    closures.push_back({from.utime, to.utime, from.world_from_robot.translation_m(),
                        to.world_from_robot.translation_m(), seen_from_now.translation_m().norm(),
                        std::abs(seen_from_now.theta_rad), loop.overlap});
  }
  return closures;
}

}  // namespace marco::slam
