#include "slam/line_slam/lines/scan_in_robot.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

bool is_return(double range_m, const SensorInfo& info) {
  return std::isfinite(range_m) && range_m > 0.0 && range_m > info.range_min_m &&
         range_m < std::min(info.range_max_m, kFarthestReturnM);
}

double mean_step_rad(const LaserScan& scan) {
  if (scan.bearings_rad.empty()) return scan.bearing_step_rad;
  if (scan.size() < 2) return 0.0;
  // Neighbour by neighbour: bearings may pass from pi to -pi within the sweep.
  double sum = 0.0;
  for (std::size_t i = 1; i < scan.size(); ++i) {
    sum += normalize_angle(scan.bearing_rad(i) - scan.bearing_rad(i - 1));
  }
  return sum / static_cast<double>(scan.size() - 1);
}

}  // namespace

void to_robot_frame(const LaserScan& scan,
                    const SensorInfo& info,
                    const Pose2& robot_motion,
                    double fallback_range_sigma_m,
                    ScanInRobot& scan_in_robot) {
  require(scan.bearings_rad.empty() || scan.bearings_rad.size() == scan.size(),
          "scan: bearings are not one a beam");
  const Pose2 robot_from_sensor = flatten(info.parent_from_sensor);
  // A laser mounted upside down sweeps the other way round seen from above.
  const double handed = info.parent_from_sensor.linear()(2, 2) < 0.0 ? -1.0 : 1.0;
  const double step_rad = handed * mean_step_rad(scan);
  const std::size_t count = scan.size();
  const bool moves =
      robot_motion.x_m != 0.0 || robot_motion.y_m != 0.0 || robot_motion.theta_rad != 0.0;
  scan_in_robot.beams.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t source = step_rad < 0.0 ? count - 1 - i : i;
    const double range_m = static_cast<double>(scan.ranges_m[source]);
    const double bearing_rad = handed * scan.bearing_rad(source);
    Beam& beam = scan_in_robot.beams[i];
    beam.range_m = range_m;
    beam.returned = is_return(range_m, info);
    if (!beam.returned) continue;
    beam.hit_m = robot_from_sensor *
                 Eigen::Vector2d(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad));
    if (moves) {
      const double part = static_cast<double>(source) / static_cast<double>(count);
      beam.hit_m = interpolate(Pose2{}, robot_motion, part) * beam.hit_m;
    }
  }
  scan_in_robot.sensor_m = robot_from_sensor.translation_m();
  const double first_rad =
      count == 0 ? 0.0 : handed * scan.bearing_rad(step_rad < 0.0 ? count - 1 : 0);
  scan_in_robot.first_bearing_rad = normalize_angle(robot_from_sensor.theta_rad + first_rad);
  scan_in_robot.bearing_step_rad = std::abs(step_rad);
  scan_in_robot.range_sigma_m =
      info.range_sigma_m > 0.0 ? info.range_sigma_m : fallback_range_sigma_m;
}

Points2 hits_of(const ScanInRobot& scan) {
  Points2 hits(2, static_cast<Eigen::Index>(scan.beams.size()));
  Eigen::Index count = 0;
  for (const Beam& beam : scan.beams) {
    if (beam.returned) hits.col(count++) = beam.hit_m;
  }
  hits.conservativeResize(2, count);
  return hits;
}

}  // namespace marco::slam
