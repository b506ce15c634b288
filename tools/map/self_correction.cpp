#include "tools/map/self_correction.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/covariance.hpp"
#include "lcm_tools/base/printable.hpp"

namespace marco {
namespace {

// The front end takes odometry for 15 % and 2 deg/m off, and reads it at a scan's stamp: half of
// the first, and twice the second, which veering wheels reach in ordinary logs, still go.
constexpr double kScaleOff = 0.075, kVeerRadPerM = 0.087, kLateS = 0.05;
constexpr double kGyroBiasRadPerS = 0.01;
// A laser turned by 0.075 rad gives the same error across the way. One that sits 0.3 m to the side
// makes the map's error 1.27 times as large.
constexpr double kTurnedDeg = 4.3, kAsideM = 0.15;
constexpr double kDoubtfulTurnDeg = 2.0;  // standard deviation

// A scale error that stretches the path by more than this, summed over all passes, is corrected.
// Furnished buildings stay below it: intel has 0.15 m, loop5 0.32 m.
constexpr double kStretchM = 0.5;
// Standard deviation of a step along its least known direction. Of those that scans know, 95 % are
// below 11 mm; along bare corridors they are 20 mm and more.
constexpr double kLeftOpenM = 0.016;

bool is_scale_off(double scale) { return std::abs(scale - 1.0) > kScaleOff; }

// By how much a parameter is surely off; 0 where it is left as it is.
double surely_off(const slam::SelfCalibration& found, const char* name) {
  constexpr double kSure = 2.0;  // standard deviations
  const slam::CalibratedParameter* parameter = found.find(name);
  if (parameter == nullptr || parameter->verdict != slam::ParameterVerdict::applied) return 0.0;
  return std::abs(parameter->found - parameter->before) - kSure * parameter->sigma;
}

// Reading between samples costs as much as a little time does: intel, "late" by -52 ms with a
// standard deviation of 11: 0.0146 m as it is, 0.0196 corrected.
bool is_late(const slam::SelfCalibration& found, const char* name) {
  return surely_off(found, name) > kLateS;
}

bool needs_correction(const OdometryCalibration& odometry, double by_odometry_m) {
  const double ahead = 0.5 * (odometry.left_scale + odometry.right_scale);
  const double track_m = kCountedTrackM * odometry.track_scale;
  const double veer = (odometry.right_scale - odometry.left_scale) / track_m;
  return odometry.forward_sign < 0.0 || odometry.turn_sign < 0.0 || is_scale_off(ahead) ||
         is_scale_off(ahead / odometry.track_scale) || std::abs(veer) > kVeerRadPerM ||
         by_odometry_m * std::abs(ahead - 1.0) > kStretchM;
}

// By so much that odometry contradicts the laser's motion: it says ahead where the laser moves
// sideways, or nothing where the robot turns and the laser swings.
bool is_turned(const slam::SelfCalibration& found) {
  return surely_off(found, "laser.yaw_deg") > kTurnedDeg;
}

bool is_aside(const slam::SelfCalibration& found) {
  return surely_off(found, "laser.x_m") > kAsideM || surely_off(found, "laser.y_m") > kAsideM;
}

bool sits_elsewhere(const slam::SelfCalibration& found) {
  return is_turned(found) || is_aside(found);
}

bool is_turn_in_doubt(const slam::SelfCalibration& found) {
  return found.find("laser.yaw_deg")->sigma > kDoubtfulTurnDeg;
}

// As found where that is surely off, as assumed where it is not.
LaserCalibration corrected_laser(const slam::SelfCalibration& found) {
  LaserCalibration laser = found.calibration.laser;
  const auto assumed = [&](const char* name) { return found.find(name)->before; };
  if (!is_turned(found)) laser.yaw_deg = assumed("laser.yaw_deg");
  if (!is_aside(found)) {
    laser.x_m = assumed("laser.x_m");
    laser.y_m = assumed("laser.y_m");
  }
  return laser;
}

Pose2 laser_as_assumed(const slam::SelfCalibration& found) {
  const auto assumed = [&](const char* name) { return found.find(name)->before; };
  return {assumed("laser.x_m"), assumed("laser.y_m"), deg_to_rad(assumed("laser.yaw_deg"))};
}

bool needs_correction(const GyroCalibration& gyro) {
  return is_scale_off(gyro.scale) || std::abs(gyro.bias_rad_per_s) > kGyroBiasRadPerS;
}

const char* to_string(slam::ParameterVerdict verdict) {
  switch (verdict) {
    case slam::ParameterVerdict::applied:
      return "off";
    case slam::ParameterVerdict::as_assumed:
      return "as_assumed";
    case slam::ParameterVerdict::no_better:
      return "no_better";
    case slam::ParameterVerdict::not_observed:
      return "not_observed";
    case slam::ParameterVerdict::undecidable:
      break;
  }
  return "undecidable";
}

const char* to_string(SelfCorrection::Use use) {
  switch (use) {
    case SelfCorrection::Use::in_force:
      return "in_force";
    case SelfCorrection::Use::rejected:
      return "rejected";
    case SelfCorrection::Use::not_needed:
      break;
  }
  return "not_needed";
}

}  // namespace

double distance_by_odometry_m(const std::vector<slam::PoseGraphEdge>& edges) {
  double distance_m = 0.0;
  for (const slam::PoseGraphEdge& edge : edges) {
    if (edge.is_loop || position_sigma_m(covariance_of(edge.information)) < kLeftOpenM) continue;
    distance_m += edge.from_from_to.translation_m().norm();
  }
  return distance_m;
}

SensorCalibration needed_correction(const slam::SelfCalibration& found, double by_odometry_m) {
  SensorCalibration needed;
  const SensorCalibration& calibration = found.calibration;
  const bool odometry_is_late = is_late(found, "odometry.late_s");
  if (needs_correction(calibration.odometry, by_odometry_m) || odometry_is_late) {
    needed.odometry = calibration.odometry;
    if (!odometry_is_late) needed.odometry.late_s = 0.0;
  }
  const bool gyro_is_late = is_late(found, "gyro.late_s");
  if (needs_correction(calibration.gyro) || gyro_is_late) {
    needed.gyro = calibration.gyro;
    if (!gyro_is_late) needed.gyro.late_s = 0.0;
  }
  const slam::CalibratedParameter* upside_down = found.find("laser.upside_down");
  if (sits_elsewhere(found) && is_turn_in_doubt(found)) return needed;
  if (sits_elsewhere(found) ||
      (upside_down != nullptr && upside_down->verdict == slam::ParameterVerdict::applied)) {
    needed.laser = corrected_laser(found);
  }
  return needed;
}

std::optional<Pose2> assumed_from_found_robot(const slam::SelfCalibration& found) {
  if (!sits_elsewhere(found)) return std::nullopt;
  const LaserCalibration laser = corrected_laser(found);
  return laser_as_assumed(found) * Pose2{laser.x_m, laser.y_m, deg_to_rad(laser.yaw_deg)}.inverse();
}

std::string doubt_of_laser(const slam::SelfCalibration& found) {
  const LaserCalibration& laser = found.calibration.laser;
  char text[400];
  std::snprintf(text, sizeof text,
                "the laser's mount seems to be %.2f %.2f m, turned by %.0f deg (sd %.1f), not the "
                "recording's: trajectory.tum is the path with the recording's mount, %s with this "
                "one. A longer drive with turns, or SENSOR_INFO with the measured mount, decides",
                laser.x_m, laser.y_m, laser.yaw_deg, found.find("laser.yaw_deg")->sigma,
                kPathAsFound);
  return text;
}

std::string describe_errors(const slam::SelfCalibration& found) {
  std::string text;
  for (const slam::CalibratedParameter& parameter : found.parameters) {
    if (parameter.verdict != slam::ParameterVerdict::applied) continue;
    char line[128];
    std::snprintf(line, sizeof line, "%s%s %g -> %.4g", text.empty() ? "" : ", ",
                  parameter.name.c_str(), parameter.before, parameter.found);
    text += line;
    if (parameter.sigma <= 0.0) continue;
    std::snprintf(line, sizeof line, " (sd %.2g)", parameter.sigma);
    text += line;
  }
  return text;
}

void add_calibration(nlohmann::json& report, const SelfCorrection& correction) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const slam::CalibratedParameter& parameter : correction.found.parameters) {
    nlohmann::json one = {{"name", parameter.name},
                          {"assumed", parameter.before},
                          {"state", to_string(parameter.verdict)}};
    if (parameter.verdict != slam::ParameterVerdict::not_observed) one["found"] = parameter.found;
    if (parameter.sigma > 0.0) one["sigma"] = parameter.sigma;
    if (!parameter.missing.empty()) one["missing"] = parameter.missing;
    parameters.push_back(one);
  }
  report["calibration"] = {{"use", to_string(correction.use)},
                           {"parameters", parameters},
                           {"remarks", correction.found.remarks}};
  if (correction.assumed_from_found_robot) report["calibration"]["path_as_found"] = kPathAsFound;
}

void print_correction(const SelfCorrection& correction) {
  const std::string errors = describe_errors(correction.found);
  if (!errors.empty()) print(stdout, "set-up: %s\n", errors.c_str());
  for (const std::string& remark : correction.found.remarks) {
    print(stdout, "  note: %s\n", remark.c_str());
  }
  if (correction.use == SelfCorrection::Use::in_force) {
    std::puts("  the map was made again with these corrected");
  } else if (correction.use == SelfCorrection::Use::rejected) {
    std::puts("  a map made with these was no better: they are not used");
  }
  if (correction.assumed_from_found_robot) {
    print(stdout, "  %s is the path for the mount as found\n", kPathAsFound);
  }
}

}  // namespace marco
