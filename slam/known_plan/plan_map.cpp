#include "slam/known_plan/plan_map.hpp"

namespace marco::slam {

SavedMap map_of_plan(const PlanSight& sight) {
  SavedMap map;
  map.session_starts = {0};
  map.slam.keyframes.keys = sight.keyframes;
  int32_t index = 0;
  for (const Keyframe& key : sight.keyframes) {
    const ScanPose pose{key.utime, index++, {}};
    map.slam.path.scans.push_back(pose);
    map.slam.path.keyframe_poses.push_back(pose);
  }
  check(map);
  return map;
}

}  // namespace marco::slam
