#pragma once

#include "common/byte_archive.hpp"
#include "slam/localization/saved_map.hpp"
#include "slam/map/slam_state.hpp"

/// The fields of Slam's state, listed once for writing and reading (common/byte_archive.hpp).
namespace marco::slam {

using marco::archive;

template <class Archive>
void archive(Archive& bytes, Keyframe& key) {
  archive(bytes, key.utime);
  archive(bytes, key.points_in_robot.points);
  archive(bytes, key.points_in_robot.normals);
  archive(bytes, key.sensor_in_robot);
  archive(bytes, key.sensor_heading_rad);
  archive(bytes, key.world_from_robot);
  archive(bytes, key.path_m);
}

template <class Archive>
void archive(Archive& bytes, PoseGraphEdge& edge) {
  archive(bytes, edge.from);
  archive(bytes, edge.to);
  archive(bytes, edge.from_from_to);
  archive(bytes, edge.information);
  archive(bytes, edge.is_loop);
}

template <class Archive>
void archive(Archive& bytes, Loop& loop) {
  archive(bytes, loop.from);
  archive(bytes, loop.to);
  archive(bytes, loop.from_from_to);
  archive(bytes, loop.believed);
  archive(bytes, loop.information);
  archive(bytes, loop.score);
  archive(bytes, loop.overlap);
  archive(bytes, loop.shift_m);
  archive(bytes, loop.turn_deg);
  archive(bytes, loop.in_force);
}

template <class Archive>
void archive(Archive& bytes, ScanPose& scan) {
  archive(bytes, scan.utime);
  archive(bytes, scan.key);
  archive(bytes, scan.key_from_robot);
}

template <class Archive>
void archive(Archive& bytes, MotionInput& input) {
  archive(bytes, input.utime);
  archive(bytes, input.odom_from_robot);
  archive(bytes, input.gyro_heading_rad);
}

template <class Archive>
void archive(Archive& bytes, MotionState::Step& step) {
  archive(bytes, step.utime);
  archive(bytes, step.then_from_now);
}

template <class Archive>
void archive(Archive& bytes, MotionState& motion) {
  archive(bytes, motion.before);
  archive_list(bytes, motion.history, sizeof(MotionState::Step));
  archive(bytes, motion.period_s);
  archive(bytes, motion.before_lag_s);
  archive(bytes, motion.move_m);
  archive(bytes, motion.turn_rad);
  archive(bytes, motion.anchor);
  archive(bytes, motion.anchor_from_before);
  archive(bytes, motion.lagging);
  archive(bytes, motion.last_step);
  archive(bytes, motion.came_with_scan);
}

template <class Archive>
void archive(Archive& bytes, StandingState& standing) {
  archive(bytes, standing.map_error);
  archive(bytes, standing.covariance);
}

template <class Archive>
void archive(Archive& bytes, SlamState& state) {
  // Fewest bytes of each: a keyframe without points, an edge, a loop, a scan.
  archive_list(bytes, state.keys, 80);
  archive_list(bytes, state.edges, 105);
  archive_list(bytes, state.loops, 161);
  archive_list(bytes, state.scans, 36);
  archive_list(bytes, state.trail, 36);
  archive(bytes, state.motion);
  archive(bytes, state.standing);
  archive(bytes, state.world_from_robot);
  archive(bytes, state.covariance);
  archive(bytes, state.local_map_centre_m);
  archive(bytes, state.last_search_path_m);
  archive(bytes, state.closed_path_m);
  archive_list(bytes, state.closings_m, sizeof(double));
  archive(bytes, state.revision);
  archive(bytes, state.looked_at);
  archive(bytes, state.thin_until);
  archive(bytes, state.kept_keys);
  archive(bytes, state.merged_keys);
  archive(bytes, state.leaps_since);
  archive(bytes, state.unmatched);
}

template <class Archive>
void archive(Archive& bytes, SavedMap& map) {
  archive(bytes, map.options);
  archive_list(bytes, map.session_starts, sizeof(int64_t));
  archive(bytes, map.slam);
}

}  // namespace marco::slam
