#pragma once

#include <optional>

#include "common/input/beam_order.hpp"
#include "common/input/deskew.hpp"
#include "common/input/pantilt_track.hpp"
#include "common/samples.hpp"

namespace marco {

/// What the robot's own sensors say at a scan's first beam.
struct MotionInput {
  Utime utime;  ///< the scan's repaired stamp (StampRepair)
  std::optional<Pose2> odom_from_robot;
  std::optional<double> gyro_heading_rad;  ///< integrated yaw rate, from any start
  double scan_period_s = 0.0;              ///< of this laser; 0 = not known yet
  double off_beat = 0.0;                   ///< see StampRepair
  Pose2 first_from_middle = {};            ///< see deskew.hpp; as the scan was deskewed

  /// What saved maps keep of it.
  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("odom_from_robot", odom_from_robot);
    v("gyro_heading_rad", gyro_heading_rad);
    v("first_from_middle", first_from_middle);
  }
};

/// A scan with everything that is known at its time.
struct SynchronizedScan {
  LaserScan scan;  ///< as measured, with its own stamp
  SensorInfo info;
  MotionInput motion;
  BeamVerdict beam_order;              ///< that it was put into, as far as it is judged
  double duration_s = 0.0;             ///< first beam to last beam
  std::optional<Pose2> odometry_step;  ///< odometry's motion from the first beam to the last
  /// Of a laser on a pan-tilt at both beams; 0 of one that is fixed, or where nothing is known.
  PanTiltAngles first_angles, last_angles;
  bool angles_known = false;
  Pose3 robot_from_sensor = Pose3::Identity();  ///< at the first beam
  /// False: the laser was tilted, panned during the scan or is mounted steeply, or it is on a
  /// pan-tilt and another one is fixed to the robot.
  bool level = true;
};

}  // namespace marco
