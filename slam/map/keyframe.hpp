#pragma once

#include <cstdint>
#include <vector>

#include "common/pose2.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"
#include "slam/matching/oriented_points.hpp"

namespace marco::slam {

/// A keyframe: a scan that is kept. The map is made of these.
struct Keyframe {
  Utime utime;
  OrientedPoints points_in_robot;
  Eigen::Vector2d sensor_in_robot = {0, 0};
  double sensor_heading_rad = 0.0;
  Pose2 world_from_robot;
  double path_m = 0.0;  ///< driven until here

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("points_in_robot", points_in_robot);
    v("sensor_in_robot", sensor_in_robot);
    v("sensor_heading_rad", sensor_heading_rad);
    v("world_from_robot", world_from_robot);
    v("path_m", path_m);
  }
};

/// When a scan becomes a keyframe.
struct KeyframeOptions {
  double keyframe_distance_m = 0.30;  ///< after this move ...
  double keyframe_turn_deg = 15.0;    ///< ... or this turn of the robot or of a panning laser

  template <class Visitor>
  void visit(Visitor& v) {
    v("keyframe_distance_m", keyframe_distance_m, kPositive,
      "The robot drives this far between two keyframes. More for large halls, to save memory and "
      "time.");
    v("keyframe_turn_deg", keyframe_turn_deg, kPositive,
      "A turn by this angle starts a new keyframe as well. Less for a narrow field of view.");
  }
};

/// The keyframes of a map, in the order they were taken.
struct KeyframeSet {
  std::vector<Keyframe> keys;
  int32_t merged = 0;  ///< keyframes that culling merged into others

  /// Keyframes ever made, the merged ones included.
  int ever() const { return static_cast<int>(keys.size()) + merged; }
  /// Whether a scan taken here shows more than the last keyframes do.
  bool is_due(const Pose2& world_from_robot,
              double sensor_heading_rad,
              const KeyframeOptions& options) const;

  template <class Visitor>
  void visit(Visitor& v) {
    v("keys", keys);
    v("merged", merged);
  }
};

/// @throws std::invalid_argument naming what is wrong: a point without a normal, a keyframe farther
/// away than any building, an impossible number of merged ones.
void check(const KeyframeSet& keyframes);

Trajectory trajectory_of(const std::vector<Keyframe>& keys);

/// Points of the keyframes first .. last in one frame. @param frame_from_world  of that frame.
OrientedPoints join_points(const std::vector<Keyframe>& keys,
                           int first,
                           int last,
                           const Pose2& frame_from_world);

/// What a saved state may hold: nothing lies farther away than 1000 km, far beyond any building and
/// far from where sums of squares lose centimetres.
bool is_near(const Pose2& pose);
bool is_index(int index, std::size_t count);

}  // namespace marco::slam
