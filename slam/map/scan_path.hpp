#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slam/map/keyframe.hpp"
#include "slam/map/keyframe_culling.hpp"

namespace marco::slam {

/// The pose of a scan relative to a keyframe: it moves with that keyframe.
struct ScanPose {
  Utime utime;
  int32_t key = -1;  ///< -1: before the first keyframe; the pose is then the world's
  Pose2 key_from_robot;
  /// The robot has not moved since the scan before: both are where this one says, as that knows of
  /// all matches of the stop.
  bool stands = false;
  bool predicted = false;  ///< by dead reckoning from the scan before: it was not matched

  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("key", key);
    v("key_from_robot", key_from_robot);
    v("stands", stands);
    v("predicted", predicted);
  }
};

struct ScanPathState {
  std::vector<ScanPose> scans;           ///< processed
  std::vector<ScanPose> keyframe_poses;  ///< of every keyframe ever made, the merged ones included
  std::optional<Pose2> odom_from_stop;   ///< where the newest scan's stop began, by odometry

  template <class Visitor>
  void visit(Visitor& v) {
    v("scans", scans);
    v("keyframe_poses", keyframe_poses);
    v("odom_from_stop", odom_from_stop);
  }
};

/// @throws std::invalid_argument for a pose relative to no keyframe or farther away than any
/// building, or more keyframe poses than there were keyframes.
void check(const ScanPathState& path, const KeyframeSet& keyframes);

Trajectory trajectory_of(const std::vector<ScanPose>& scans, const std::vector<Keyframe>& keys);

/// The path driven: the pose of each scan, relative to a keyframe. Not thread-safe.
class ScanPath {
 public:
  const ScanPathState& state() const { return state_; }
  void restore(const ScanPathState& state);

  /// See Slam::keep_short_path.
  void keep_short(double every_m, std::size_t first);

  /// The newest scan; relative to the newest keyframe, if there is any.
  /// @param odom_from_robot  if it is believed: scans between which it stands still are of one
  /// stop, as long as they lie within 5 cm and 2 degrees of where it began. The wheels may stand
  /// still while the robot is pushed, and odometry may have stopped working.
  /// @param predicted  see ScanPose
  void add_scan(const StampedPose2& scan,
                const std::optional<Pose2>& odom_from_robot,
                bool predicted,
                const std::vector<Keyframe>& keys);
  /// Call when a scan was matched, before the keyframes move. The error of its prediction had grown
  /// over the predicted scans before it: each takes its share of the turn and of the shift, in
  /// proportion to the way, for a robot that stands does not err.
  /// @param from  where the prediction began: near the scan that was matched before
  void spread_correction(const Pose2& from,
                         const Pose2& predicted,
                         const Pose2& world_from_robot,
                         const std::vector<Keyframe>& keys);
  /// Call before the keyframes move. Scans that were predicted between two keyframes take their
  /// share of how the second moves relative to the first, as above.
  void spread_moves(const std::vector<Keyframe>& keys, const std::vector<Pose2>& world_from_keys);
  void add_keyframe(Utime utime, int key) { state_.keyframe_poses.push_back({utime, key, {}}); }
  /// Another session's path: its keyframes follow those that are there.
  void append(const ScanPathState& session, int first_key, const Pose2& world_from_session);

  /// Keyframe `key` is about to be merged into another one, and removed.
  /// @param keys  before that
  void reattach_to_keyframe(int key,
                            const MergedKeyframe& merged,
                            const std::vector<Keyframe>& keys);
  /// Of a short path: drops keyframe poses when there are too many for the map's size.
  void shorten(const std::vector<Keyframe>& keys);

  Trajectory scans(const std::vector<Keyframe>& keys) const {
    return trajectory_of(state_.scans, keys);
  }
  Trajectory keyframes(const std::vector<Keyframe>& keys) const {
    return trajectory_of(state_.keyframe_poses, keys);
  }

 private:
  bool is_worth_keeping(const ScanPose& scan) const;
  /// Whether the robot is where the newest scan's stop began.
  bool is_at_stop(const Pose2& world_from_robot, const std::vector<Keyframe>& keys) const;
  void remove_scans_of(int key);

  ScanPathState state_;
  std::size_t stop_begins_ = 0;    ///< the first scan of the newest one's stop
  std::optional<double> every_m_;  ///< of a short path
  std::size_t short_from_ = 0;     ///< scans before this one are kept
};

}  // namespace marco::slam
