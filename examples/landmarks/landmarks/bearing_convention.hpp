#pragma once

#include <optional>
#include <vector>

#include "landmarks/landmark_slam_options.hpp"
#include "landmarks/sighting.hpp"

namespace marco::slam {

/// How a file counts bearings.
struct BearingConvention {
  double zero_rad = 0.0;  ///< of straight ahead, where the file's bearing is 0, counter-clockwise
  double sign = 1.0;      ///< 1 = counter-clockwise

  double straight(double bearing_rad) const;
};

/// Wheel velocities and scans of a drive, each in order of time.
struct LandmarkDrive {
  std::vector<WheelVelocity> wheels;
  std::vector<SightingScan> scans;
};

/// Finds the convention under which landmarks stay where they are: the beginning of the drive is
/// mapped with zero ahead, left, right and behind, and with both senses. @returns nothing where two
/// of them explain it about as well: a straight way, no landmarks.
std::optional<BearingConvention> find_bearing_convention(const LandmarkDrive& drive,
                                                         const LandmarkSlamOptions& options);

/// The drive's scans with bearings from straight ahead, counter-clockwise.
void straighten_bearings(const BearingConvention& convention, std::vector<SightingScan>& scans);

}  // namespace marco::slam
