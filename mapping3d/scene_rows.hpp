#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/input/pantilt_correction.hpp"
#include "common/input/sensor_synchronizer.hpp"
#include "common/pose_estimate.hpp"
#include "mapping3d/path_correction.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// Where SLAM puts the robot at each scan: of all keyframes, and of the last ten seconds' scans.
/// Not thread-safe.
class ScanPoses {
 public:
  void add(const PoseEstimate& pose);

  std::size_t size() const { return poses_.size(); }
  /// @returns nullptr where there is none.
  const Pose2* find(Utime utime) const;
  /// Whether there is a pose at `utime`, and one at or after `until`.
  bool reach(Utime utime, Utime until) const;
  /// Between the poses of two scans; beyond the newest as if the robot drove on. Only for a moment
  /// at or after a scan that has a pose.
  Pose2 at(Utime utime) const;
  /// Whether two poses in a row, the second after `from` and not after `until`, surely differ.
  bool moved_between(Utime from, Utime until) const;
  /// The same until the first pose at or after `until`; false where there is none yet.
  bool moved_until_pose_at(Utime from, Utime until) const;

  PathCorrection correction_by(const Trajectory& keys) const { return {keys, poses_}; }
  /// Moves all poses. Of those older than ten seconds and before `oldest_needed` only keyframes'
  /// are kept: scenes are attached to these.
  void follow(const PathCorrection& correction, std::optional<Utime> oldest_needed);

 private:
  std::map<Utime, Pose2> poses_;  ///< as known today
  std::optional<PoseEstimate> newest_;
  std::set<Utime> moved_at_;  ///< poses, of those, that surely differ from the one before
};

/// A row, and the other arguments of Mapper3d::add().
struct PlacedRow {
  SceneRow row;
  double pan_rad = 0.0, tilt_rad = 0.0;  ///< in the middle of the row
  std::string laser;
};

/// Whether a scan can be a row of a scene: its bearings are evenly spaced.
bool has_even_bearings(const LaserScan& scan);

/// Makes scans rows of scenes. A scan waits for its pose, of the same stamp, and for the next one,
/// which gives the robot's motion during the scan. The pan-tilt's angles at its first and last beam
/// place the laser. Odometry and SLAM together decide which rows were measured from one stop. The
/// result depends only on the order of scans and poses and on their stamps. Not thread-safe.
class SceneRows {
 public:
  using CountDrop = SensorSynchronizer::CountDrop;

  /// @param patience_s  a scan waits for its pose until there is a scan newer by this
  /// @param drop  called for each scan that becomes no row, with the cause
  SceneRows(const PanTiltCorrection& correction, double patience_s, CountDrop drop);

  /// @param scan  has even bearings
  void add(SynchronizedScan scan);
  void add(const PoseEstimate& pose) { poses_.add(pose); }
  /// @param pantilt_base  of the pan-tilt on the robot; nullptr: not known yet
  /// @returns the row of the oldest scan, if its pose is there. Call until it returns nothing.
  std::optional<PlacedRow> next(const SensorInfo* pantilt_base);
  /// No more poses will come: what still waits is used with those that are there.
  void complete_all() { complete_ = true; }

  PathCorrection correction_by(const Trajectory& keys) const { return poses_.correction_by(keys); }
  /// Later poses come in the new frame, so those of waiting scans are moved into it.
  void follow(const PathCorrection& correction);

  /// When the newest scan was measured.
  Utime newest() const { return newest_; }
  std::size_t known_poses() const { return poses_.size(); }

 private:
  /// Where the robot stands.
  struct Stop {
    Utime since, newest;    ///< its first scan and its last one
    Pose2 odom_from_robot;  ///< at the first
  };

  bool is_due(const SynchronizedScan& scan) const;
  std::optional<PlacedRow> row_of(const SynchronizedScan& scan, const SensorInfo* pantilt_base);
  bool stands_during(const SynchronizedScan& scan) const;
  /// The first scan of the stop that this one belongs to; nothing without odometry.
  std::optional<Utime> stop_of(const SynchronizedScan& scan);

  PanTiltCorrection correction_;
  double patience_s_;
  CountDrop drop_;
  ScanPoses poses_;
  std::optional<Stop> stop_;
  std::deque<SynchronizedScan> waiting_;
  Utime newest_;
  bool complete_ = false;
};

}  // namespace marco::mapping3d
