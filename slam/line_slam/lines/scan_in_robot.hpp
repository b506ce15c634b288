#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/samples.hpp"

namespace marco::slam {

/// One ray of a sweep.
struct Beam {
  Eigen::Vector2d hit_m = Eigen::Vector2d::Zero();  ///< robot frame; only if `returned`
  double range_m = 0.0;                             ///< from the sensor
  bool returned = false;                            ///< whether anything came back from it
};

/// A sweep in the robot's frame at one moment, counter-clockwise.
struct ScanInRobot {
  std::vector<Beam> beams;                             ///< in order of growing bearing
  Eigen::Vector2d sensor_m = Eigen::Vector2d::Zero();  ///< where the rays start, robot frame
  double first_bearing_rad = 0.0;                      ///< of beams[0], robot frame
  double bearing_step_rad = 0.0;     ///< mean step between neighbours, > 0 with two beams or more
  double range_sigma_m = 0.01;       ///< standard deviation of one range
  double bearing_sigma_rad = 0.001;  ///< standard deviation of one bearing
};

/// A measured scan brought into the robot's frame at the moment of its first beam.
/// A clockwise sweep is turned round; ranges outside (info.range_min_m, info.range_max_m), not
/// finite or 0 are no returns.
/// @param robot_motion  pose of the robot at the last beam seen from the robot at the first; each
///                      hit is moved by its share of it (straight blend).
/// @param fallback_range_sigma_m  used where info.range_sigma_m is 0 (not known).
/// @param scan_in_robot  overwritten; keeps its memory, so that a second call allocates nothing.
/// @throws std::invalid_argument when the scan holds bearings but not one a beam.
void to_robot_frame(const LaserScan& scan,
                    const SensorInfo& info,
                    const Pose2& robot_motion,
                    double fallback_range_sigma_m,
                    ScanInRobot& scan_in_robot);

/// Where beams ended, in their order: 2xN [m], robot frame; returns only.
Points2 hits_of(const ScanInRobot& scan);

}  // namespace marco::slam
