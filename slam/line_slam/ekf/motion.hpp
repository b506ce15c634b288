#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Error model of odometry (thesis A, 5.10-5.14). The defaults are for unknown wheels: a wrong data
/// association costs more than walls that correct a little less.
struct MotionNoiseOptions {
  double distance_sigma_part = 0.10;      ///< alpha_d: along the move, of its length
  double direction_sigma_part = 0.05;     ///< alpha_psi: of the angle between heading and move
  double heading_sigma_part = 0.20;       ///< alpha_theta: of the turn
  double heading_sigma_rad_per_m = 0.10;  ///< drift of the heading on the way
  double floor_m = 0.01;                  ///< of any move, along and across
  double floor_rad = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("distance_sigma_part", distance_sigma_part, Limits{0.0, 10.0},
      "Standard deviation of a move, as a fraction of its length. More for wheels that slip.");
    v.advanced("direction_sigma_part", direction_sigma_part, Limits{0.0, 10.0},
               "Standard deviation of a move's direction, as a fraction of the angle between "
               "heading and move.");
    v("heading_sigma_part", heading_sigma_part, Limits{0.0, 10.0},
      "Standard deviation of a turn, as a fraction of it. More for skid steering.");
    v.advanced("heading_sigma_rad_per_m", heading_sigma_rad_per_m, kNotNegative,
               "Drift of the heading per metre.");
  }
};

/// (5.2): the robot's pose after it moved by `robot_motion`, seen from where it was.
inline Pose2 moved(const Pose2& world_from_robot, const Pose2& robot_motion) {
  return world_from_robot * robot_motion;
}

/// (5.9) F_r = d moved / d world_from_robot. First-estimates form: the lever arm is the way from
/// `from_m`, the point where the pose before was linearized, to the new position, so that turning
/// robot and map together stays unobservable. With from_m the pose before itself it is (5.9).
Eigen::Matrix3d motion_jacobian(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);

/// (5.10-5.14) V_r: covariance of the moved pose's error that the move adds.
/// As printed, a straight move has no error across it nor of heading, and one backwards (psi = pi)
/// a huge one across: here the length is signed, with psi in (-pi/2, pi/2], the heading drifts with
/// the way, and all three have floors. A move of exactly zero adds nothing.
Eigen::Matrix3d motion_noise(const MotionNoiseOptions& options,
                             double heading_rad,
                             const Pose2& robot_motion);

}  // namespace marco::slam
