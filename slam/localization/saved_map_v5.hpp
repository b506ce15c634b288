#pragma once

#include "common/byte_archive.hpp"
#include "slam/localization/saved_map.hpp"

/// Map files of version 5, as programs wrote them before the state of Slam was divided: the layout
/// never changes again.
namespace marco::slam::version_5 {

struct MotionInput {
  Utime utime;
  std::optional<Pose2> odom_from_robot;
  std::optional<double> gyro_heading_rad;

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("odom_from_robot", odom_from_robot);
    v("gyro_heading_rad", gyro_heading_rad);
  }
};

/// The rhythm of the scans, which comes after `history`, is read and learned again.
struct Motion {
  std::optional<MotionInput> before;
  std::deque<DeadReckoningState::Step> history;
  double period_s = 0.0, before_lag_s = 0.0, move_m = 0.0, turn_rad = 0.0;
  std::optional<MotionInput> anchor;
  Pose2 anchor_from_before;
  int32_t lagging = 0;
  Pose2 last_step;
  int32_t came_with_scan = 0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("before", before);
    v("history", history);
    v("period_s", period_s);
    v("before_lag_s", before_lag_s);
    v("move_m", move_m);
    v("turn_rad", turn_rad);
    v("anchor", anchor);
    v("anchor_from_before", anchor_from_before);
    v("lagging", lagging);
    v("last_step", last_step);
    v("came_with_scan", came_with_scan);
  }
};

struct Keyframe {
  Utime utime;
  Points2 points, normals;
  Eigen::Vector2d sensor_in_robot = {0, 0};
  double sensor_heading_rad = 0.0;
  Pose2 world_from_robot;
  double path_m = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("points", points);
    v("normals", normals);
    v("sensor_in_robot", sensor_in_robot);
    v("sensor_heading_rad", sensor_heading_rad);
    v("world_from_robot", world_from_robot);
    v("path_m", path_m);
  }
};

struct ScanPose {
  Utime utime;
  int32_t key = -1;
  Pose2 key_from_robot;

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("key", key);
    v("key_from_robot", key_from_robot);
  }
};

inline std::vector<slam::ScanPose> read_path(const std::vector<ScanPose>& stored) {
  std::vector<slam::ScanPose> path;
  for (const ScanPose& scan : stored) path.push_back({scan.utime, scan.key, scan.key_from_robot});
  return path;
}

struct File {
  SavedMap map;
  std::vector<ScanPose> scans, trail;
  std::vector<Keyframe> keys;
  Motion motion;
  double last_search_path_m = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    SlamState& slam = map.slam;
    v("options", map.options);
    v("session_starts", map.session_starts);
    v("keys", keys);
    v("edges", slam.back_end.edges);
    v("loops", slam.back_end.loops);
    v("scans", scans);
    v("trail", trail);
    v("motion", motion);
    v("standing", slam.zero_velocity);
    v("world_from_robot", slam.estimate.world_from_robot);
    v("covariance", slam.estimate.covariance);
    v("local_map_centre_m", slam.local_map_centre_m);
    v("last_search_path_m", last_search_path_m);
    v("closed_path_m", slam.back_end.closed_path_m);
    v("closings_m", slam.back_end.loop_closings_m);
    v("revision", slam.revision);
    v("looked_at", slam.culling.next);
    v("thin_until", slam.culling.until);
    v("kept_keys", slam.culling.kept);
    v("merged_keys", slam.keyframes.merged);
    v("leaps_since", slam.gate.jumps_since);
    v("unmatched", slam.gate.unmatched);
  }
};

/// @throws std::invalid_argument as archive().
inline SavedMap read(ByteReader& bytes) {
  File file;
  archive(bytes, file);
  MotionState& motion = file.map.slam.motion;
  file.map.slam.back_end.next_search_path_m =
      file.last_search_path_m + LoopCloserOptions{}.attempt_every_m;
  if (file.motion.before) {
    MotionInput& before = *file.motion.before;
    auto& now = motion.before.emplace();
    now.utime = before.utime;
    now.odom_from_robot = before.odom_from_robot;
    now.gyro_heading_rad = before.gyro_heading_rad;
    motion.reckoning.newest = before.utime;
  }
  motion.reckoning.history = file.motion.history;
  file.map.slam.path.scans = read_path(file.scans);
  file.map.slam.path.keyframe_poses = read_path(file.trail);
  for (Keyframe& key : file.keys) {
    const double sigma_m = range_sigma_of(key.points, key.sensor_in_robot).value_or(0.0);
    file.map.slam.keyframes.keys.push_back(
        {key.utime,
         {std::move(key.points), std::move(key.normals), sigma_m},
         key.sensor_in_robot,
         key.sensor_heading_rad,
         key.world_from_robot,
         key.path_m});
  }
  return std::move(file.map);
}

}  // namespace marco::slam::version_5
