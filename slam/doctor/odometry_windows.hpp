#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "common/trajectory.hpp"

namespace marco::slam {

/// A stretch of path over which the map and the odometry disagree by more than they usually do.
struct OdometryBreak {
  Utime from;
  Utime to;
  double length_m = 0.0;  ///< of the window, along the map's path
  Pose2 map;              ///< its end seen from its start, by the map
  Pose2 odometry;         ///< and by the odometry
  Pose2 world_from_end;
  double turned_rad = 0.0;  ///< by the odometry, turns to either side added up
  double longer_m = 0.0;    ///< the map's way than the odometry's, scaled as the log teaches
  bool is_turn = false;     ///< they part by a turn rather than by the way
  double sigmas = 0.0;      ///< of the noise learned from all windows of this length

  /// Between the ends of both.
  double off_m() const { return (map.translation_m() - odometry.translation_m()).norm(); }
  double off_rad() const { return std::abs(normalize_angle(map.theta_rad - odometry.theta_rad)); }
};

/// How the odometry goes with the map.
struct OdometryAgreement {
  bool present = false;         ///< the robot moved, and so did the odometry
  double turn_correlation = 0;  ///< of turns in steps of 0.3 m or 10 deg; 0 where there are few
  /// Of the ways in the same steps, whichever way the laser looks; negative: it looks back.
  double way_correlation = 0;
  std::vector<OdometryBreak> breaks;  ///< the worst first; of windows that overlap the worst one
};

/// The way between two stamps by the odometry. @returns nothing where it has none of them
std::optional<Pose2> way_by_odometry(const Trajectory& odometry, Utime from, Utime to);

/// Compares both over windows of 1, 2, 4 .. 64 m. Noise is learned from the log: the median of all
/// windows of a length, and their median absolute deviation from it, so that systematic errors and
/// a few breaks count for nothing.
/// @param path, odometry  in the order of the recording; poses of other stamps are left out
OdometryAgreement compare_with_odometry(const Trajectory& path, const Trajectory& odometry);

}  // namespace marco::slam
