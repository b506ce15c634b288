#pragma once

#include <functional>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "common/pose3.hpp"
#include "simulator/devices/laser_world.hpp"
#include "simulator/devices/transport/emulator.hpp"
#include "simulator/laser_model.hpp"
#include "simulator/live/faults.hpp"
#include "simulator/live/robot_spec.hpp"

namespace marco::sim {

/// The laser device in front of a world. @throws std::invalid_argument for an unknown spec.device.
std::unique_ptr<drivers::Emulator> laser_emulator(const LiveLaserSpec& spec,
                                                  drivers::LaserWorld world);

/// What the laser of a moving robot measures, with the faults `wrong` and `stuck`.
class LiveLaser {
 public:
  using Trajectory = std::function<Pose3(Utime)>;

  /// @param rays, faults  outlive it. @param world_from_sensor  at any time of the last 0.1 s
  LiveLaser(const RayCaster& rays,
            const LiveLaserSpec& spec,
            Trajectory world_from_sensor,
            const FaultBoard& faults,
            uint64_t seed);

  std::vector<double> sweep(const drivers::LaserSweep& sweep);

 private:
  const RayCaster& rays_;
  LiveLaserSpec spec_;
  Trajectory world_from_sensor_;
  const FaultBoard& faults_;
  std::mt19937_64 random_;
  std::map<long, std::vector<double>> last_answers_;  ///< by sector of the first bearing
};

}  // namespace marco::sim
