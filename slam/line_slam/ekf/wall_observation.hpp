#pragma once

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "slam/line_slam/lines/observed_wall.hpp"

namespace marco::slam {

/// Estimates of robot and one wall, and the points where Jacobians are taken.
struct WallContext {
  Eigen::Vector3d robot;        ///< x y theta, world frame
  Eigen::Vector3d robot_first;  ///< first estimate of this step: as predicted
  Eigen::Vector4d wall;         ///< x1 y1 x2 y2, world frame
  Eigen::Vector4d wall_first;
  int block = 0;  ///< of the wall in the state
};

/// Which ends of an observed wall are the map wall's own.
struct MatchedEnds {
  bool start = false;
  bool end = false;
};

/// The wall's ends seen from the robot (5.16): z = R^T (x - t). @returns x1 y1 x2 y2, robot frame.
Eigen::Vector4d seen_from_robot(const Eigen::Vector3d& robot, const Eigen::Vector4d& wall);

/// (5.24-5.25) d z / d (x_r, y_r, theta_r) and d z / d wall, at the given points.
void seen_from_robot_jacobians(const Eigen::Vector3d& robot,
                               const Eigen::Vector4d& wall,
                               Eigen::Matrix<double, 4, 3>& by_robot,
                               Eigen::Matrix4d& by_wall);

/// The measurement of a map wall by an observed wall (5.2.5, corrected): Jacobian, innovation,
/// noise.
///
/// Rows 0 and 1: the offsets of the map wall's two ends across the observed line; their noise is
/// the line's, extrapolated to the ends. They say nothing along the wall, so occlusion causes no
/// false certainty. Then one row per matched end: its position along the wall.
SparseRows wall_rows(const ObservedWall& observed, const WallContext& at, MatchedEnds ends);

}  // namespace marco::slam
