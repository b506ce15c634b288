#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/pose2.hpp"
#include "common/samples.hpp"
#include "simulator/laser_model.hpp"
#include "simulator/simulation_options.hpp"
#include "simulator/tour.hpp"

namespace marco::sim {

/// Odometry with systematic errors, drift and slip, from the true pose at a steady rate.
class OdometryModel {
 public:
  /// Draws this run's signs from `random`.
  OdometryModel(const OdometryOptions& options,
                const Pose2& world_from_robot,
                std::mt19937_64& random);

  /// @returns odom_from_robot after the robot moved to `world_from_robot`.
  const Pose2& move_to(const Pose2& world_from_robot, std::mt19937_64& random);

 private:
  OdometryOptions options_;
  double distance_scale_;
  double turn_scale_;
  double drift_rad_per_m_;
  double to_next_slip_m_ = 0.0;
  Pose2 world_from_robot_;
  Pose2 odom_from_robot_;
};

/// What a driver and a logger with faults make of a scan's times.
class LoggerModel {
 public:
  /// @throws std::invalid_argument for an unknown logger.beam_times.
  LoggerModel(const LoggerOptions& options, const LaserOptions& laser);

  /// When a beam is measured [s after the scan began], where its message says `said_s`.
  double measured_s(double said_s) const;
  /// From first beam to last, as in SENSOR_INFO.
  double told_duration_s() const;
  /// The stamp of a scan that began at `began_s` after `start`. @returns nothing when the scan is
  /// lost.
  std::optional<Utime> stamp(Utime start, double began_s, std::mt19937_64& random);
  /// The messages in which a scan is sent.
  /// @param scan  with its stamp, without bearings and times of its beams
  std::vector<LaserScan> messages(const LaserScan& scan) const;

 private:
  enum class BeamTimes { right, milliseconds, reversed, equal, missing };
  static BeamTimes named(const std::string& name);
  float told_offset_s(int beam) const;

  LoggerOptions options_;
  LaserOptions laser_;
  BeamTimes beam_times_;
  std::optional<Utime> last_stamp_;
};

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
