#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "common/samples.hpp"
#include "simulator/laser_model.hpp"
#include "simulator/logger_model.hpp"
#include "simulator/odometry_model.hpp"
#include "simulator/tour.hpp"

namespace marco::sim {

/// Drives a tour through a world in simulated time and gives what the robot's sensors would send,
/// in the order of sending. A scan comes after its last beam: on LIDAR_RAW with the time of every
/// beam, then on LIDAR with the same utime, unless the logger's faults tell otherwise.
/// Deterministic from its seed.
class BatchSimulation {
 public:
  /// The first scan's time: a literal, so that two runs are equal byte for byte.
  static constexpr Utime kStart{1'700'000'000'000'000};

  /// @param rays outlives the simulation. @throws std::invalid_argument for invalid options, or for
  /// a tour that sweeps without a pan-tilt.
  BatchSimulation(const RayCaster& rays,
                  const Tour& tour,
                  const SimulationOptions& options,
                  uint64_t seed);

  double duration_s() const { return plan_.duration_s(); }

  /// @param sent  called with each sample and the moment it is sent
  /// @param progress  called with the part done, now and then; may be empty
  void run(const std::function<void(const Sample&, Utime)>& sent,
           const std::function<void(double)>& progress = {});

  /// Where the laser is at a moment of the tour, on the uneven floor.
  Pose3 world_from_laser(double seconds) const;

 private:
  bool has_pantilt() const { return options_.robot.pantilt_state_hz > 0.0; }
  void send_infos(double seconds);
  void send_odometry(double seconds);
  void send_pantilt(double seconds);
  void send_scan(double first_beam_s);
  void send_level_scan(double first_beam_s);
  Pose3 world_from_robot(double seconds) const;
  void send(const Sample& sample, double seconds);
  Utime utime_at(double seconds) const { return kStart + Duration::from_seconds(seconds); }

  SimulationOptions options_;
  MotionPlan plan_;
  LaserModel laser_;
  SensorInfo base_info_;
  SensorInfo laser_info_;
  std::optional<SensorInfo> level_info_;  ///< of a second laser
  std::mt19937_64 random_;
  OdometryModel odometry_;
  LoggerModel logger_;
  std::function<void(const Sample&, Utime)> sent_;
};

}  // namespace marco::sim
