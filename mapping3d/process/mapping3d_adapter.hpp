#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/input/sensor_synchronizer.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "mapping3d/calibration.hpp"
#include "mapping3d/mapper3d.hpp"
#include "mapping3d/scene_rows.hpp"

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

/// Messages in, SensorSynchronizer, SceneRows, Mapper3d, messages out. Scans of lasers on the
/// pan-tilt, and of those fixed steeply to the robot, become rows of scenes by their SLAM_POSE.
/// Each finished sweep is published as SCENE, and the model, its scenes registered in 3D, as MESH
/// tiles below 300 kB. TRAJECTORY moves scenes whose keyframes moved. What it does depends on the
/// order of messages and their stamps alone.
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
  std::size_t known_poses() const { return rows_.known_poses(); }

  /// The pan-tilt's geometry from the scenes so far; nothing without scenes or SENSOR_INFO.
  std::optional<CalibrationResult> calibrate(const CalibrationOptions& options = {}) const;

 private:
  void subscribe();
  bool is_wanted(const LaserScan& scan);
  void use_complete_scans();
  void refine();
  void publish_scene(const Scene& scene);
  void publish_model();
  void follow(const Trajectory& keys);

  process::Bus& bus_;
  process::DropCounter drops_;
  Mapper3d mapper_;
  SensorSynchronizer input_;
  SceneRows rows_;
  int64_t revision_ = 0;
  std::function<void(const std::string&)> on_long_work_;
};

}  // namespace marco::mapping3d
