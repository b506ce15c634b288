#pragma once

#include <string>
#include <vector>

#include "common/input/sensor_calibration.hpp"
#include "common/trajectory.hpp"
#include "slam/calibration/input_check.hpp"

namespace marco::slam {

/// What one drive measured.
struct CalibrationInput {
  std::string channel = "LIDAR";   ///< the laser's
  Trajectory world_from_laser;     ///< a pose a scan, by scan matching
  Pose2 robot_from_laser;          ///< as assumed so far
  bool laser_upside_down = false;  ///< likewise
  Trajectory odometry;             ///< raw; may be empty
  Trajectory gyro_heading;         ///< raw rate, integrated, as poses that only turn; may be empty
};

/// Why a parameter changes, or does not.
enum class ParameterVerdict {
  applied,       ///< more than 3 standard deviations off, and better on motions held out
  as_assumed,    ///< within 3 standard deviations of what was assumed
  no_better,     ///< motions held out are explained no better, or the map is no sharper
  not_observed,  ///< the drive does not hold it
  undecidable,   ///< another change explains the same; that one is taken
};

struct CalibratedParameter {
  std::string name;  ///< SensorCalibration's, e.g. "laser.x_m"
  double before = 0.0;
  double found = 0.0;
  double sigma = 0.0;  ///< standard deviation; 0 of a sign
  ParameterVerdict verdict = ParameterVerdict::as_assumed;
  std::string missing;  ///< what a drive would need, where it is not observed
};

struct SelfCalibration {
  std::vector<CalibratedParameter> parameters;
  SensorCalibration calibration;  ///< what is applied, over what was assumed
  InputCheck odometry;
  InputCheck gyro;
  std::vector<std::string> remarks;  ///< for users: what is wrong, or cannot be determined
  std::string open_question;  ///< whether the map is a mirror image, and what settles it; "" sure

  /// nullptr: there is no such parameter.
  const CalibratedParameter* find(const std::string& name) const;
};

/// For a table: "applied", or why not.
std::string reason_of(const CalibratedParameter& parameter);

/// Where the laser sits, how the wheels and the gyroscope count and how late they are, from any
/// drive with turns. Signs: a laser upside down and odometry that counts turns the wrong way round
/// give the same data, and mirrored maps; only a gyroscope decides, and without one odometry is
/// believed. A laser that looks back and odometry that counts backwards give the same map; robots
/// are taken to drive ahead more than back. Range scale and wheel scale trade: ranges are believed.
SelfCalibration self_calibrate(const CalibrationInput& input);

}  // namespace marco::slam
