#include "tools/map/recorded.hpp"

#include <algorithm>

#include "common/input/sensor_synchronizer.hpp"

namespace marco {

void Recorded::add(const Sample& sample) {
  if (const auto* pose = std::get_if<TruePose>(&sample)) truth.add(*pose);
  if (const auto* imu = std::get_if<ImuSample>(&sample)) integrate(*imu);
  if (const auto* scan = std::get_if<LaserScan>(&sample)) note_bearings(*scan);
  if (const auto* info = std::get_if<SensorInfo>(&sample)) note_sensor(sensors, *info);
  if (const auto* sampled = std::get_if<OdometrySample>(&sample)) {
    odometry.push_back({sampled->utime, sampled->odom_from_robot});
  }
}

double Recorded::least_bearing_rad(const std::string& channel) const {
  const auto found = least_bearing_rad_.find(channel);
  return found == least_bearing_rad_.end() ? 0.0 : found->second;
}

void Recorded::note_bearings(const LaserScan& scan) {
  if (scan.size() == 0 || least_bearing_rad_.contains(scan.channel)) return;
  double least_rad = scan.bearing_rad(0);
  for (std::size_t i = 1; i < scan.size(); ++i) {
    least_rad = std::min(least_rad, scan.bearing_rad(i));
  }
  least_bearing_rad_[scan.channel] = least_rad;
}

void Recorded::integrate(const ImuSample& sample) {
  double heading_rad = 0.0;
  if (!gyro_heading.empty()) {
    const StampedPose2& last = gyro_heading.back();
    if (sample.utime <= last.utime) return;
    heading_rad = integrated_heading_rad(last, sample).value_or(last.world_from_robot.theta_rad);
  }
  gyro_heading.push_back({sample.utime, {0.0, 0.0, heading_rad}});
}

}  // namespace marco
