#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "common/input/sensor_synchronizer.hpp"
#include "common/pose_estimate.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "mapping3d/calibration.hpp"
#include "mapping3d/mapper3d.hpp"

namespace marco::mapping3d {

struct Mapping3dAdapterOptions {
  Mapper3dOptions mapper;
  SynchronizerOptions input;     ///< a scan waits for its pose by the same patience
  PanTiltCorrection correction;  ///< from `--calibration FILE`, no setting of its own

  template <class Visitor>
  void visit(Visitor& v) {
    v("model", mapper);
    v("input", input);
  }
};

/// Messages in, Mapper3d, messages out. Scans of lasers on the pan-tilt, and of those fixed steeply
/// to the robot, come out of a SensorSynchronizer with the angles at their first and last beam, and
/// wait for their SLAM_POSE (of the same stamp). Each finished sweep is published as SCENE, and the
/// model, its scenes registered in 3D, as MESH tiles below 300 kB. TRAJECTORY moves scenes whose
/// keyframes moved. What it does depends on the order of messages and their stamps alone.
class Mapping3dAdapter {
 public:
  /// @param bus outlives the adapter. @param warn see process::DropCounter.
  Mapping3dAdapter(process::Bus& bus,
                   const Mapping3dAdapterOptions& options,
                   std::function<void(const std::string&)> warn = {});

  /// @param on_long_work  is called before each step that may take many seconds: "busy: ..."
  void announce_long_work(std::function<void(const std::string&)> on_long_work) {
    on_long_work_ = std::move(on_long_work);
  }

  /// Uses the scans that still wait, ends the current sweep, publishes the model.
  void finish();

  const Mapper3d& mapper() const { return mapper_; }
  /// See Mapper3d::finish_model; no more messages are taken.
  void finish_model() { mapper_.finish_model(); }
  const process::DropCounter& drops() const { return drops_; }
  /// Number of remembered scan poses: of keyframes, and of ten seconds before the last TRAJECTORY.
  std::size_t known_poses() const { return poses_.size(); }

  /// The pan-tilt's geometry from the scenes so far; nothing without scenes or SENSOR_INFO.
  std::optional<CalibrationResult> calibrate(const CalibrationOptions& options = {}) const;

 private:
  /// Where the robot stands.
  struct Stop {
    Utime since, newest;    ///< its first scan and its last one
    Pose2 odom_from_robot;  ///< at the first
  };

  void subscribe();
  void note_pose(const PoseEstimate& pose);
  /// Whether SLAM's poses between these moments contradict odometry that stands.
  bool moved_between(Utime from, Utime until) const;
  bool stands_during(const SynchronizedScan& scan) const;
  /// The first scan of the stop that this one belongs to; nothing without odometry.
  std::optional<Utime> stop_of(const SynchronizedScan& scan);
  bool is_wanted(const LaserScan& scan);
  void use_complete_scans();
  bool has_pose(const SynchronizedScan& scan) const;
  void use(const SynchronizedScan& scan);
  void refine();
  void publish_scene(const Scene& scene);
  void publish_model(Utime utime);
  void follow(const Trajectory& keys);
  /// Of scans that were used, only keyframes' poses are kept: scenes are attached to these.
  void forget_poses_between(const PathCorrection& keys);
  Pose2 pose_at(Utime utime) const;

  process::Bus& bus_;
  Mapping3dAdapterOptions options_;
  process::DropCounter drops_;
  Mapper3d mapper_;
  SensorSynchronizer input_;
  std::map<Utime, Pose2> poses_;  ///< of keyframes and of the last scans, as known today
  std::optional<PoseEstimate> newest_pose_;
  std::set<Utime> moved_at_;  ///< poses, of those, that are surely not the one before
  std::optional<Stop> stop_;
  std::deque<SynchronizedScan> waiting_;
  Utime newest_;
  int64_t revision_ = 0;
  std::function<void(const std::string&)> on_long_work_;
};

}  // namespace marco::mapping3d
