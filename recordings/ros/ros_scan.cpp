#include "recordings/ros/ros_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

// As a laser that is mounted upside down.
void mirror(LaserScan& scan) {
  scan.first_bearing_rad = -scan.first_bearing_rad;
  scan.bearing_step_rad = -scan.bearing_step_rad;
  for (float& bearing : scan.bearings_rad) bearing = -bearing;
}

// The stamp is that of the first beam unless stated otherwise.
void shift(LaserScan& scan, double duration_s, const std::string& stamped_beam) {
  const double part = stamped_beam == "last" ? 1.0 : stamped_beam == "middle" ? 0.5 : 0.0;
  scan.utime = scan.utime - Duration::from_seconds(part * duration_s);
}

}  // namespace

double beam_step_rad(const LaserScanMessage& message, std::size_t beams) {
  const double told = static_cast<double>(message.angle_increment);
  const double steps = static_cast<double>(beams) - 1.0;
  const bool fits = told != 0.0 && std::abs(told) * steps < 2.1 * std::numbers::pi;
  if (fits || steps < 1.0) return told;
  return (static_cast<double>(message.angle_max) - static_cast<double>(message.angle_min)) / steps;
}

LaserScan to_scan(const LaserScanMessage& message,
                  const LaserPlan& laser,
                  const RosOptions& options) {
  require(message.ranges.size() >= 2, "scan of fewer than 2 beams");
  require(std::isfinite(message.angle_min) && std::isfinite(message.angle_increment),
          "scan with angles that are not finite");
  LaserScan scan;
  scan.channel = laser.scan_channel;
  scan.ranges_m = message.ranges;
  scan.first_bearing_rad = static_cast<double>(message.angle_min);
  scan.bearing_step_rad = beam_step_rad(message, message.ranges.size());
  require(std::isfinite(scan.bearing_step_rad) && scan.bearing_step_rad != 0.0,
          "scan with all beams in one direction");
  if (laser.tells_beam_times) {
    scan.time_offsets_s.reserve(message.ranges.size());
    for (std::size_t beam = 0; beam < message.ranges.size(); ++beam) {
      scan.time_offsets_s.push_back(static_cast<float>(beam) * message.time_increment);
    }
    // lidar_raw_t has a bearing a beam.
    for (std::size_t beam = 0; beam < message.ranges.size(); ++beam) {
      scan.bearings_rad.push_back(static_cast<float>(
          scan.first_bearing_rad + static_cast<double>(beam) * scan.bearing_step_rad));
    }
  }
  if (options.clockwise) mirror(scan);
  shift(scan, laser.duration_s, options.stamp);
  return scan;
}

LaserScan to_scan(const CloudMessage& cloud, const LaserPlan& laser, const RosOptions& options) {
  LaserScan scan;
  scan.channel = laser.scan_channel;
  if (auto ranges_m = laser.bearings.ranges_m(cloud); !ranges_m.empty()) {
    scan.ranges_m = std::move(ranges_m);
    scan.first_bearing_rad = laser.bearings.first_rad();
    scan.bearing_step_rad = laser.bearings.step_rad();
    if (options.clockwise) mirror(scan);
    return scan;
  }
  require(cloud.points.size() >= 2, "scan of fewer than 2 beams");
  for (const Eigen::Vector3f& point : cloud.points) {
    scan.ranges_m.push_back(point.head<2>().norm());
    scan.bearings_rad.push_back(std::atan2(point.y(), point.x()));
  }
  if (options.clockwise) mirror(scan);
  return scan;
}

}  // namespace marco::ros
