#include "mapping3d/path_correction.hpp"

#include <iterator>

namespace marco::mapping3d {

PathCorrection::PathCorrection(const Trajectory& keys, const std::map<Utime, Pose2>& known) {
  for (const StampedPose2& key : keys) {
    const auto before = known.find(key.utime);
    if (before == known.end()) continue;
    today_from_before_[key.utime] = key.world_from_robot * before->second.inverse();
  }
}

Pose2 PathCorrection::corrected(Utime utime, const Pose2& world_from_robot) const {
  const auto after = today_from_before_.upper_bound(utime);
  if (after == today_from_before_.begin()) return world_from_robot;
  return std::prev(after)->second * world_from_robot;
}

}  // namespace marco::mapping3d
