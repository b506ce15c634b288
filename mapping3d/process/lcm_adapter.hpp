#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/samples.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "mapping3d/calibration.hpp"
#include "mapping3d/mapper3d.hpp"
#include "mapping3d/pantilt_track.hpp"

namespace marco::mapping3d {

struct Mapping3dAdapterOptions {
  Mapper3dOptions mapper;
  double patience_s =
      0.5;  ///< how long a scan waits for its pose and the pan-tilt, in message time
  double pantilt_gap_s = 1.0;    ///< angles are interpolated between states so far apart
  double pantilt_reach_s = 0.1;  ///< and carried on beyond the newest
  PanTiltCorrection correction;  ///< of the SENSOR_INFOs, as a calibration found it

  template <class Visitor>
  void visit(Visitor& v) {
    v("mapper", mapper);
    v("patience_s", patience_s, Limits{0.0, 10.0});
    v("pantilt_gap_s", pantilt_gap_s, Limits{0.0, 60.0});
    v("pantilt_reach_s", pantilt_reach_s, Limits{0.0, 10.0});
    v("correction", correction);
  }
};

/// Messages in, Mapper3d, messages out: scans of lasers on the pan-tilt wait for their SLAM_POSE
/// (same stamp) and for the pan-tilt's angles at their last beam; each finished sweep is sent as
/// SCENE and the model, its scenes joined in 3D, as MESH tiles below 300 kB. TRAJECTORY moves
/// scenes whose keyframes moved. Decides by the order of messages and their stamps alone.
class Mapping3dAdapter {
 public:
  /// @param bus outlives the adapter. @param warn see process::DropCounter.
  Mapping3dAdapter(process::Bus& bus,
                   const Mapping3dAdapterOptions& options,
                   std::function<void(const std::string&)> warn = {});

  /// Uses what still waits, ends the sweep under way, sends the model.
  void finish();

  const Mapper3d& mapper() const { return mapper_; }
  const process::DropCounter& drops() const { return drops_; }
  /// Poses of scans it remembers: of keyframes, and of the last ten seconds since a TRAJECTORY.
  std::size_t known_poses() const { return poses_.size(); }

  /// The pan-tilt's geometry from the scenes so far; nothing without scenes or without
  /// SENSOR_INFO.
  std::optional<CalibrationResult> calibrate(const CalibrationOptions& options = {}) const;

 private:
  void subscribe();
  void on_scan(LaserScan scan);
  void use_waiting();
  bool ready(const LaserScan& scan) const;
  void use(const LaserScan& scan);
  void publish_scene(const Scene& scene);
  void publish_model(Utime utime);
  void follow(const Trajectory& keys);
  /// Of scans that were used, the keyframes' alone: what follows a TRAJECTORY hangs on these.
  void forget_poses_between(const std::map<Utime, Pose2>& keys);
  Pose2 pose_at(Utime utime) const;

  process::Bus& bus_;
  Mapping3dAdapterOptions options_;
  process::DropCounter drops_;
  Mapper3d mapper_;
  std::map<std::string, SensorInfo> sensors_;
  PanTiltTrack pantilt_;
  std::map<Utime, Pose2> poses_;  ///< of keyframes and of the last scans, as known today
  std::deque<LaserScan> waiting_;
  Utime newest_;
  int64_t revision_ = 0;
};

}  // namespace marco::mapping3d
