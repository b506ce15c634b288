#pragma once

#include <cstdint>
#include <vector>

#include "common/grid_map.hpp"
#include "common/pose2.hpp"

namespace marco::slam {

/// How well a map predicts held-out scans.
struct PredictionQuality {
  int64_t beams = 0;            ///< judged: those that the map knows up to a wall
  double median_error_m = 0.0;  ///< of |range the map predicts - range measured|
  double through_walls = 0.0;   ///< part that ended > 0.3 m behind a wall of the map
  double short_of_walls = 0.0;  ///< part that ended > 0.3 m before it (people, moved objects)
};

/// A scan and where it was taken.
struct PlacedScan {
  Pose2 world_from_robot;
  Points2 hits_in_robot;
  Eigen::Vector2d sensor_in_robot = {0, 0};
};

/// Follows each beam through the map to the first occupied cell (>= 50 %). Not judged: beams that
/// meet unknown space first, or no wall within a metre behind their measured end.
PredictionQuality judge_prediction(const GridMap& map, const std::vector<PlacedScan>& scans);

}  // namespace marco::slam
