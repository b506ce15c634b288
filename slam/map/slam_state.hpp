#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/trajectory.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/zero_velocity_update.hpp"

namespace marco::slam {

/// A processed scan hangs on a keyframe, and moves with it.
struct ScanPose {
  Utime utime;
  int32_t key = -1;  ///< -1: before the first keyframe; then the pose is the world's
  Pose2 key_from_robot;

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("key", key);
    v("key_from_robot", key_from_robot);
  }
};

/// All that Slam knows: what it has to be given back to go on as if it had never stopped.
struct SlamState {
  std::vector<Keyframe> keys;
  std::vector<PoseGraphEdge> edges;
  std::vector<Loop> loops;  ///< one a loop edge, in their order
  std::vector<ScanPose> scans;
  std::vector<ScanPose> trail;  ///< of keyframes that ever were, those of `keys` among them
  MotionState motion;
  std::optional<StandingState> standing;
  Pose2 world_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector2d local_map_centre_m = Eigen::Vector2d::Zero();
  double last_search_path_m = 0.0;
  double closed_path_m = 0.0;
  std::vector<double> closings_m;  ///< path driven when the last loops were closed
  int64_t revision = 0;
  int32_t looked_at = 0;  ///< of the keyframes that may become one: see Slam
  int32_t thin_until = 0;
  int32_t kept_keys = 0;
  int32_t merged_keys = 0;           ///< so many have become one with an older
  std::optional<Utime> leaps_since;  ///< since then each match put the robot where it cannot be
  int32_t unmatched = 0;  ///< scans of late that fitted nothing, one after the other; counted to 3

  template <class Visitor>
  void visit(Visitor& v) {
    v("keys", keys);
    v("edges", edges);
    v("loops", loops);
    v("scans", scans);
    v("trail", trail);
    v("motion", motion);
    v("standing", standing);
    v("world_from_robot", world_from_robot);
    v("covariance", covariance);
    v("local_map_centre_m", local_map_centre_m);
    v("last_search_path_m", last_search_path_m);
    v("closed_path_m", closed_path_m);
    v("closings_m", closings_m);
    v("revision", revision);
    v("looked_at", looked_at);
    v("thin_until", thin_until);
    v("kept_keys", kept_keys);
    v("merged_keys", merged_keys);
    v("leaps_since", leaps_since);
    v("unmatched", unmatched);
  }
};

/// The poses of keyframes, and of the scans that hang on them.
Trajectory trajectory_of(const std::vector<Keyframe>& keys);
Trajectory trajectory_of(const std::vector<ScanPose>& scans, const std::vector<Keyframe>& keys);

/// @throws std::invalid_argument naming what contradicts itself: an index of nothing, a scan whose
/// normals are not one a point, a number of loops that is not that of the loop edges; or what lies
/// farther away than any building: 1000 km.
void check(const SlamState& state);

}  // namespace marco::slam
