#pragma once

#include <map>

#include "common/trajectory.hpp"

namespace marco::mapping3d {

/// How SLAM's path has changed: whatever was seen after a keyframe moves with that keyframe.
class PathCorrection {
 public:
  /// @param keys   keyframes where they lie today
  /// @param known  scans where they lay until now
  PathCorrection(const Trajectory& keys, const std::map<Utime, Pose2>& known);

  /// A pose at `utime`, where it lies today; unchanged before the first keyframe.
  Pose2 corrected(Utime utime, const Pose2& world_from_robot) const;
  bool has_key(Utime utime) const { return today_from_before_.contains(utime); }

 private:
  std::map<Utime, Pose2> today_from_before_;  ///< by keyframe
};

}  // namespace marco::mapping3d
