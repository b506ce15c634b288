#pragma once

#include <filesystem>
#include <vector>

#include "common/trajectory.hpp"
#include "tools/evaluate/model_judge.hpp"

namespace marco {

struct TrueBeams {
  Trajectory truth;           ///< of the robot
  std::vector<BeamEnd> ends;  ///< of the beams of 3D sweeps, without noise
  std::size_t scans = 0;      ///< those of sweeps
};

/// Where the beams of a simulated recording's 3D sweeps (the pan-tilt moves meanwhile) end in its
/// world, by TRUE_POSE, PANTILT_STATE and SENSOR_INFO. Its measured ranges are not looked at, but
/// a beam that returned nothing met nothing.
TrueBeams true_beams(const std::filesystem::path& recording, const sim::RayCaster& world);

}  // namespace marco
