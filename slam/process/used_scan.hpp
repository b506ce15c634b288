#pragma once

#include <Eigen/Core>
#include <utility>

#include "slam/slam.hpp"

namespace marco::slam {

/// The result of a scan, for judging the map afterwards.
struct UsedScan {
  int hits = 0;  ///< beams with a return in range
  bool level = true;
  bool held_out = false;
  bool matched = false;
  /// Of a held-out scan [m], deskewed: keyframes hold the points of what is drawn.
  Points2 hits_in_robot;
  Eigen::Vector2d sensor_in_robot = {0, 0};  ///< [m]
};

/// What is kept of a scan that was processed.
/// @param matched  whether a match gave it its pose
inline UsedScan used_scan(SlamInput input, bool matched) {
  UsedScan used;
  used.hits = input.scan.beams - input.scan.no_return;
  used.level = input.level;
  used.held_out = !input.may_draw;
  used.matched = matched;
  if (used.held_out) used.hits_in_robot = std::move(input.scan.hits_in_robot);
  used.sensor_in_robot = input.scan.sensor_in_robot;
  return used;
}

}  // namespace marco::slam
