#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/input/deskew.hpp"

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

/// All beams of a scan, returned or not, in order of growing bearing, with the hits of its deskewed
/// returns. A clockwise sweep is reversed, one in any other order is sorted.
/// @param robot_from_sensor  at the first beam
/// @param fallback_range_sigma_m  used where info.range_sigma_m is 0 (not known)
/// @throws std::invalid_argument for fewer than two beams, or bearings that are not one a beam.
ScanInRobot to_robot_frame(const LaserScan& scan,
                           const SensorInfo& info,
                           const Pose3& robot_from_sensor,
                           const DeskewedScan& deskewed,
                           double fallback_range_sigma_m);

/// Where beams ended, in their order: 2xN [m], robot frame; returns only.
Points2 hits_of(const ScanInRobot& scan);

}  // namespace marco::slam
