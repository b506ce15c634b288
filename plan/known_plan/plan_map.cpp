#include "plan/known_plan/plan_map.hpp"

namespace marco::plan {

slam::SavedMap map_of_plan(const PlanSight& sight) {
  slam::SavedMap map;
  map.session_starts = {0};
  map.slam.keyframes.keys = sight.keyframes;
  int32_t index = 0;
  for (const slam::Keyframe& key : sight.keyframes) {
    const slam::ScanPose pose{key.utime, index++, {}};
    map.slam.path.scans.push_back(pose);
    map.slam.path.keyframe_poses.push_back(pose);
  }
  check(map);
  return map;
}

}  // namespace marco::plan
