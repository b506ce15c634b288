#include "slam/landmarks/bearing_convention.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/pose2.hpp"
#include "slam/landmarks/landmark_slam.hpp"

namespace marco::slam {
namespace {

constexpr double kQuarter = 0.5 * std::numbers::pi;
constexpr std::size_t kScans = 500;        // with sightings, of a robot that moves
constexpr double kClearPart = 0.9;         // the next best convention pairs fewer than this
constexpr double kMovingMPerS = 0.02;

// The part of the drive that tells most: the first scans while it moves.
LandmarkDrive beginning_of(const LandmarkDrive& drive) {
  LandmarkDrive part;
  const auto moves = std::find_if(
      drive.wheels.begin(), drive.wheels.end(),
      [](const WheelVelocity& sample) { return std::abs(sample.speed_m_per_s) > kMovingMPerS; });
  if (moves == drive.wheels.end()) return part;
  for (const SightingScan& scan : drive.scans) {
    if (scan.utime < moves->utime || scan.sightings.empty()) continue;
    if (part.scans.size() == kScans) break;
    part.scans.push_back(scan);
  }
  if (part.scans.empty()) return part;
  for (const WheelVelocity& sample : drive.wheels) {
    if (sample.utime >= moves->utime && sample.utime <= part.scans.back().utime) {
      part.wheels.push_back(sample);
    }
  }
  return part;
}

int paired_under(const BearingConvention& convention,
                 LandmarkDrive drive,
                 const LandmarkSlamOptions& options) {
  straighten_bearings(convention, drive.scans);
  LandmarkSlam slam(options);
  int paired = 0;
  std::size_t next = 0;
  for (const SightingScan& scan : drive.scans) {
    while (next < drive.wheels.size() && drive.wheels[next].utime <= scan.utime) {
      slam.process(drive.wheels[next++]);
    }
    paired += slam.process(scan).paired;
  }
  return paired;
}

}  // namespace

double BearingConvention::straight(double bearing_rad) const {
  return normalize_angle(sign * bearing_rad + zero_rad);
}

void straighten_bearings(const BearingConvention& convention, std::vector<SightingScan>& scans) {
  for (SightingScan& scan : scans) {
    for (Sighting& sighting : scan.sightings) {
      sighting.bearing_rad = convention.straight(sighting.bearing_rad);
    }
  }
}

std::optional<BearingConvention> find_bearing_convention(const LandmarkDrive& drive,
                                                         const LandmarkSlamOptions& options) {
  const LandmarkDrive part = beginning_of(drive);
  LandmarkSlamOptions fixed = options;
  fixed.learn_noise = false;  // a wrong convention must not be learned as noise
  std::optional<BearingConvention> best;
  int most = 0, next = 0;
  for (const double zero_rad : {0.0, kQuarter, -kQuarter, 2.0 * kQuarter}) {
    for (const double sign : {1.0, -1.0}) {
      const BearingConvention convention{zero_rad, sign};
      const int paired = paired_under(convention, part, fixed);
      if (paired > most) {
        next = most;
        most = paired;
        best = convention;
      } else {
        next = std::max(next, paired);
      }
    }
  }
  if (next > kClearPart * most) return std::nullopt;
  return best;
}

}  // namespace marco::slam
