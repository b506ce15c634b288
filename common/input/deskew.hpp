#pragma once

#include <cstdint>
#include <vector>

#include "common/samples.hpp"

namespace marco {

/// The robot's velocity, in its own frame.
struct Velocity2 {
  double ahead_m_per_s = 0.0;
  double left_m_per_s = 0.0;
  double yaw_rad_per_s = 0.0;

  /// The pose reached after `seconds` at constant velocity, seen from the start (the exact arc).
  Pose2 after(double seconds) const;
};

/// The velocity that leads to `moved` in `seconds`: the inverse of Velocity2::after, to first order
/// in the turn.
Velocity2 velocity_of(const Pose2& moved, double seconds);

/// A deskewed scan: its returns, projected on the floor plan, as if all beams had been measured at
/// the first beam's time.
struct DeskewedScan {
  Utime utime;
  Points2 hits_in_robot;                     ///< 2xN [m], in the order of the beams
  Eigen::Vector2d sensor_in_robot = {0, 0};  ///< [m]
  std::vector<int32_t> beam_of_hit;          ///< one a column: its index in the LaserScan
  std::vector<float> time_of_hit_s;          ///< one a column: since `utime`
  Velocity2 velocity;                        ///< it was deskewed by
  double sensor_heading_rad = 0.0;           ///< of the sensor's x axis, seen from the robot
  int beams = 0;                             ///< as measured
  int no_return = 0;  ///< outside the range limits, 0, NaN, infinite or negative

  /// What checkpoints keep of it.
  template <class Visitor>
  void visit(Visitor& v) {
    v("utime", utime);
    v("hits_in_robot", hits_in_robot);
    v("sensor_in_robot", sensor_in_robot);
    v("sensor_heading_rad", sensor_heading_rad);
    v("beams", beams);
    v("no_return", no_return);
  }
};

/// @param robot_from_sensor  at the scan's time; a tilted mounting is projected on the floor.
/// @param velocity  the robot's during the scan: it undoes the motion since the first beam.
/// Beam times are the scan's own, or spread evenly over info.scan_duration_s.
DeskewedScan deskew_and_project(const LaserScan& scan,
                                const SensorInfo& info,
                                const Pose3& robot_from_sensor,
                                const Velocity2& velocity);

/// The same scan, deskewed by another velocity, or with other times of its hits.
DeskewedScan deskewed_again(DeskewedScan scan,
                            std::vector<float> time_of_hit_s,
                            const Velocity2& velocity);

/// The way from the scan's first beam to the middle of its hits' times. A match, which is rigid,
/// finds the pose at the middle: that is the same, to first order, whatever velocity the scan was
/// deskewed by. The pose at the first beam is not.
Pose2 first_from_middle(const DeskewedScan& scan);

}  // namespace marco
