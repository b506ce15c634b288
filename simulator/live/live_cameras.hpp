#pragma once

#include <optional>
#include <vector>

#include "common/samples.hpp"
#include "simulator/live/robot_spec.hpp"
#include "simulator/ray_caster.hpp"

namespace marco::sim {

/// The cameras of a robot in the simulated world. Takes the pictures that are due, given the
/// robot's pose and its pan-tilt's state. Runs in its own process: a picture takes longer than the
/// devices' lines may wait.
class LiveCameras {
 public:
  /// @param rays outlives it. @throws std::invalid_argument for an invalid spec.
  LiveCameras(const RayCaster& rays, const RobotSpec& spec);

  struct Shot {
    std::size_t camera = 0;  ///< of the spec
    Utime utime;             ///< of the pose it was taken from
    std::vector<uint8_t> rgb;
  };

  void on_pantilt(const PanTiltState& state) { pantilt_ = state.angles(); }
  /// @returns the pictures due. A camera on a pan-tilt takes none before the first state.
  std::vector<Shot> on_pose(const TruePose& pose);

  /// As the driver of a real camera publishes it: pose and focal length.
  const SensorInfo& info(std::size_t camera) const { return infos_[camera]; }
  const std::vector<LiveCameraSpec>& specs() const { return specs_; }

 private:
  std::optional<Pose3> robot_from_camera(std::size_t camera) const;

  const RayCaster& rays_;
  std::vector<LiveCameraSpec> specs_;
  std::vector<SensorInfo> infos_;
  std::vector<Utime> next_;
  SensorInfo base_;  ///< of the pan-tilt
  std::optional<PanTiltAngles> pantilt_;
};

}  // namespace marco::sim
