#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

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
/// than the front end allows for. Where the laser sits is left as the recording says: the path is
/// that of this place, and keeps its meaning. @returns the calibration as it is where none is.
SensorCalibration needed_correction(const slam::SelfCalibration& found);

/// `odometry.left_scale 1 -> 1.9 (sd 0.003), ...`: what is clearly off; "" for nothing.
std::string describe_errors(const slam::SelfCalibration& found);

/// The field `calibration` of report.json.
void add_calibration(nlohmann::json& report, const SelfCorrection& correction);

/// For a person: what is off, and what was done about it. Nothing where nothing is.
void print_correction(const SelfCorrection& correction);

}  // namespace marco
