#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "common/trajectory_fit.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// What the recordings of a job contain besides scans.
struct Recorded {
  std::vector<files::InputReport> inputs;
  std::map<std::string, SensorInfo> sensors;  ///< the newest of each channel, corrected mounts
  RecordedTruth truth;
  Trajectory odometry;      ///< as recorded, all of it
  Trajectory gyro_heading;  ///< the gyroscope's rate, integrated: poses that only turn

  void add(const Sample& sample);
  /// The least bearing of a laser's beams in its first scan; 0 without one.
  double least_bearing_rad(const std::string& channel) const;

 private:
  void note_bearings(const LaserScan& scan);
  void integrate(const ImuSample& sample);

  std::map<std::string, double> least_bearing_rad_;
};

}  // namespace marco
