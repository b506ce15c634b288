#pragma once

#include <nlohmann/json_fwd.hpp>
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
};

/// The corrections of odometry and gyroscope, and of a laser upside down, if any is off by more
/// than the front end allows for, or bends the map where only odometry told the way. A time is
/// corrected where it is surely off by more than 50 ms. Where the laser sits is left as the
/// recording says: the path is that of this place, and keeps its meaning. Where it is surely more
/// than 0.15 m or 4.3 degrees off, odometry is transformed to this place.
/// @param by_odometry_m  see distance_by_odometry_m()
/// @returns the calibration as it is where none is.
SensorCalibration needed_correction(const slam::SelfCalibration& found, double by_odometry_m);

/// Path along which the scans left a direction open, so that odometry told the way: bare corridors
/// and gaps [m]. @param edges  of the pose graph
double distance_by_odometry_m(const std::vector<slam::PoseGraphEdge>& edges);

/// `odometry.left_scale 1 -> 1.9 (sd 0.003), ...`: what is clearly off; "" for nothing.
std::string describe_errors(const slam::SelfCalibration& found);

/// The field `calibration` of report.json.
void add_calibration(nlohmann::json& report, const SelfCorrection& correction);

/// For a person: what is off, and what was done about it. Nothing where nothing is.
void print_correction(const SelfCorrection& correction);

}  // namespace marco
