#pragma once

#include <memory>
#include <vector>

#include "recordings/sample_reader.hpp"

namespace marco::testing {

/// A recording read to its end, sorted by kind.
struct Recorded {
  std::vector<SensorInfo> infos;
  std::vector<LaserScan> scans;
  std::vector<OdometrySample> odometry;
  std::vector<ImuSample> imu;
  std::vector<PanTiltState> pantilt;
  std::vector<TruePose> truth;
  files::InputReport report;
};

inline Recorded read_all(files::SampleReader& reader) {
  Recorded recorded;
  while (auto sample = reader.next()) {
    if (auto* info = std::get_if<SensorInfo>(&*sample)) recorded.infos.push_back(*info);
    if (auto* scan = std::get_if<LaserScan>(&*sample)) recorded.scans.push_back(*scan);
    if (auto* odometry = std::get_if<OdometrySample>(&*sample))
      recorded.odometry.push_back(*odometry);
    if (auto* imu = std::get_if<ImuSample>(&*sample)) recorded.imu.push_back(*imu);
    if (auto* state = std::get_if<PanTiltState>(&*sample)) recorded.pantilt.push_back(*state);
    if (auto* pose = std::get_if<TruePose>(&*sample)) recorded.truth.push_back(*pose);
  }
  recorded.report = reader.report();
  return recorded;
}

}  // namespace marco::testing
