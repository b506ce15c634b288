#include "landmarks/bearing_convention.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/median.hpp"
#include "common/pose2.hpp"
#include "landmarks/landmark_slam.hpp"

namespace marco::slam {
namespace {

constexpr double kQuarter = 0.5 * std::numbers::pi;
constexpr std::size_t kScans = 200;  // are enough to try each convention with
constexpr double kClearPart = 0.9;   // the next best convention pairs fewer than this
// Scans this far apart: a wrong convention then moves landmarks by more than their noise.
constexpr double kApartRad = 0.15;
constexpr double kApartPart = 0.1;  // of the median range

double median_range(const LandmarkDrive& drive) {
  std::vector<double> ranges;
  for (const SightingScan& scan : drive.scans) {
    for (const Sighting& sighting : scan.sightings) ranges.push_back(sighting.range_m);
  }
  return ranges.empty() ? 1.0 : median(std::move(ranges));
}

// The part of the drive that tells most: the first scans that are apart.
LandmarkDrive beginning_of(const LandmarkDrive& drive) {
  LandmarkDrive part;
  const double apart_m = kApartPart * median_range(drive);
  WheelIntegral wheels;
  std::size_t next = 0;
  for (const SightingScan& scan : drive.scans) {
    if (part.scans.size() == kScans) break;
    for (; next < drive.wheels.size() && drive.wheels[next].utime <= scan.utime; ++next) {
      wheels.add(drive.wheels[next], SetUpVector::Zero(), {});
      part.wheels.push_back(drive.wheels[next]);
    }
    const Pose2& moved = wheels.motion().start_from_end;
    if (scan.sightings.empty() ||
        (moved.translation_m().norm() < apart_m && std::abs(moved.theta_rad) < kApartRad)) {
      continue;
    }
    part.scans.push_back(scan);
    wheels.restart();
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
  // A wrong convention must not be learned as noise or as a turned sensor.
  fixed.learn_noise = false;
  fixed.set_up.sensor_yaw_sigma_rad = 0.0;
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
  if (next >= kClearPart * most) return std::nullopt;
  return best;
}

}  // namespace marco::slam
