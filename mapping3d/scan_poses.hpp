#pragma once

#include <map>
#include <optional>
#include <set>

#include "common/pose_estimate.hpp"
#include "mapping3d/path_correction.hpp"

namespace marco::mapping3d {

/// Where SLAM puts the robot at each scan: of all keyframes, and of the last ten seconds' scans.
/// Not thread-safe.
class ScanPoses {
 public:
  void add(const PoseEstimate& pose);

  std::size_t size() const { return poses_.size(); }
  /// nullptr: SLAM has not said.
  const Pose2* find(Utime utime) const;
  /// Whether the pose of this moment is known, and a pose at or after the other.
  bool reach(Utime utime, Utime until) const;
  /// Between the poses of two scans; beyond the newest as if the robot drove on. Only for a moment
  /// at or after a scan that has a pose.
  Pose2 at(Utime utime) const;
  /// Whether two poses in a row, the second after `from` and not after `until`, surely differ.
  bool moved_between(Utime from, Utime until) const;
  /// The same until the first pose at or after `until`; false where there is none yet.
  bool moved_until_pose_at(Utime from, Utime until) const;

  PathCorrection correction_by(const Trajectory& keys) const { return {keys, poses_}; }
  /// Moves all poses, and forgets those that are no keyframe's, older than ten seconds, and before
  /// `oldest_needed`: scenes are attached to keyframes.
  void follow(const PathCorrection& correction, std::optional<Utime> oldest_needed);

 private:
  std::map<Utime, Pose2> poses_;  ///< as known today
  std::optional<PoseEstimate> newest_;
  std::set<Utime> moved_at_;  ///< poses, of those, that surely differ from the one before
};

}  // namespace marco::mapping3d
