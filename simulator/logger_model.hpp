#pragma once

#include <optional>
#include <random>
#include <vector>

#include "common/laser_scan.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

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

}  // namespace marco::sim
