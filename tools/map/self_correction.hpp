#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "slam/back_end/graph/pose_graph_edge.hpp"
#include "slam/calibration/self_calibration.hpp"

namespace marco {

/// What a recording's set-up was found to be, and whether its map was made with that.
struct SelfCorrection {
  slam::SelfCalibration found;
  enum class Use {
    not_needed,  ///< the front end copes with what is off
    in_force,    ///< the map was made again, corrected
    rejected     ///< the map made with it was worse
  };
  Use use = Use::not_needed;
  /// Where the laser seems to sit elsewhere than the map was made with: the robot by that, seen
  /// from the one whose path it is.
  std::optional<Pose2> assumed_from_found_robot;
};

/// The file of that robot's path.
inline constexpr const char* kPathAsFound = "trajectory_as_found.tum";

/// The corrections of odometry, gyroscope and laser, if any is off by more than the front end
/// allows for, or bends the map where only odometry determined the path. A time is corrected where
/// it is surely off by more than 50 ms, and the laser's place where it is surely more than 0.15 m
/// or 4.3 degrees off and its heading known to 2 degrees: the path is that of the point whose
/// motion odometry reports.
/// @param by_odometry_m  see distance_by_odometry_m()
/// @returns the calibration as it is where none is.
SensorCalibration needed_correction(const slam::SelfCalibration& found, double by_odometry_m);

/// Where the laser surely sits elsewhere than assumed: the robot as found, seen from the assumed
/// one.
std::optional<Pose2> assumed_from_found_robot(const slam::SelfCalibration& found);

/// For a person: that this is not sure, and what settles it.
std::string doubt_of_laser(const slam::SelfCalibration& found);

/// Path along which the scans left a direction open, so that odometry determined it: bare corridors
/// and gaps [m]. @param edges  of the pose graph
double distance_by_odometry_m(const std::vector<slam::PoseGraphEdge>& edges);

/// `odometry.left_scale 1 -> 1.9 (sd 0.003), ...`: what is clearly off; "" for nothing.
std::string describe_errors(const slam::SelfCalibration& found);

/// The field `calibration` of report.json.
void add_calibration(nlohmann::json& report, const SelfCorrection& correction);

/// For a person: what is off, and what was done about it. Nothing where nothing is.
void print_correction(const SelfCorrection& correction);

}  // namespace marco
