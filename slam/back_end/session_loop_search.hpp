#pragma once

#include <vector>

#include "slam/back_end/loop_closer.hpp"

namespace marco::slam {

/// Loop closures between a map and a session that was appended to it: each keyframe of the session
/// searches the map, as if it had been driven to after the map's last one. Not thread-safe.
class SessionLoopSearch {
 public:
  /// @param closer  outlives the search
  /// @param keys  of both; those of the session begin at `first_key`
  /// @param searched_path_m  of the last search before
  SessionLoopSearch(const LoopCloser& closer,
                    const std::vector<Keyframe>& keys,
                    int first_key,
                    double searched_path_m);

  /// Call for each keyframe of the session in turn. @returns loops from the map to it.
  std::vector<Loop> search(const std::vector<Keyframe>& keys, int key);
  /// Keyframes have moved. @param key  the last one searched for
  void update_poses(const std::vector<Keyframe>& keys, int key);

 private:
  const LoopCloser* closer_;
  int first_key_;
  double searched_path_m_;
  /// The map's keyframes, a gap of empty ones, and the session's last ones: what is matched
  /// together around a place ends between the sessions.
  std::vector<Keyframe> nearby_;
};

}  // namespace marco::slam
