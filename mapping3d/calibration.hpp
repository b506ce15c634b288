#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surfels.hpp"

namespace marco::mapping3d {

/// What a calibration adds to a pan-tilt's and its laser's SENSOR_INFO. Height and pan zero are not
/// in it: no scan can tell them.
struct PanTiltCorrection {
  double axis_x_m = 0.0;   ///< tilt axis ahead of the pan axis
  double axis_y_m = 0.0;   ///< laser left of the pan axis
  double lever_x_m = 0.0;  ///< laser ahead of the tilt axis, at tilt 0
  double lever_z_m = 0.0;  ///< laser above the tilt axis, at tilt 0
  double roll_deg = 0.0;   ///< of the laser on the tilted plate
  double pitch_deg = 0.0;  ///< the same, > 0 looks down: the tilt's zero
  double yaw_deg = 0.0;    ///< the same: the bearings' zero

  template <class Visitor>
  void visit(Visitor& v) {
    v("axis_x_m", axis_x_m);
    v("axis_y_m", axis_y_m);
    v("lever_x_m", lever_x_m);
    v("lever_z_m", lever_z_m);
    v("roll_deg", roll_deg);
    v("pitch_deg", pitch_deg);
    v("yaw_deg", yaw_deg);
  }

  SensorInfo base(SensorInfo as_said) const;
  SensorInfo sensor(SensorInfo as_said) const;
};

struct PanTiltGeometry {
  SensorInfo base;
  SensorInfo sensor;
};

struct CalibrationOptions {
  SurfelOptions surfels;
  double search_start_m = 0.6;
  double search_end_m = 0.15;
  double lorentz_start_m = 0.1;
  double lorentz_end_m = 0.015;
  double shrink = 0.6;
  double max_normal_deg = 30.0;
  double thin_m = 0.003;
  double prior_m = 0.1;    ///< how wrong lengths may be ...
  double prior_deg = 5.0;  ///< ... and angles; a parameter no scan tells keeps its value
  double same_stop_m =
      0.1;  ///< scenes from places farther apart are not compared: the path's error
  int max_iterations = 30;

  template <class Visitor>
  void visit(Visitor& v) {
    v("surfels", surfels);
    v("search_start_m", search_start_m, kPositive);
    v("search_end_m", search_end_m, kPositive);
    v("lorentz_start_m", lorentz_start_m, kPositive);
    v("lorentz_end_m", lorentz_end_m, kPositive);
    v("shrink", shrink, Limits{0.1, 0.99});
    v("max_normal_deg", max_normal_deg, Limits{1.0, 90.0});
    v("thin_m", thin_m, kPositive);
    v("prior_m", prior_m, kPositive);
    v("prior_deg", prior_deg, kPositive);
    v("same_stop_m", same_stop_m, kPositive);
    v("max_iterations", max_iterations, Limits{1, 1000});
  }
};

struct CalibrationResult {
  enum class Status { converged, not_converged, nothing_seen_twice };
  Status status = Status::nothing_seen_twice;
  PanTiltCorrection correction;  ///< of the geometry that was given
  PanTiltCorrection sigma;       ///< standard deviation of each; near the prior where no scan tells
  std::size_t pairs = 0;         ///< patches seen twice
  double before_m = 0.0;         ///< median distance of such patches with the geometry as given
  double after_m = 0.0;
};

/// e.g. "nothing seen twice"
std::string to_string(CalibrationResult::Status status);

/// Estimates lever arms, axis offsets and zero angles of a laser on a pan-tilt: planes that sweeps
/// from one stop saw twice (at several pans, or by tilt and by pan) must coincide. Gauss-Newton as
/// in register_scenes(), but what moves the patches is the geometry, by central differences.
/// Good from about 5 deg and 5 cm off.
/// @param scenes  rows with their pan and tilt angles; each with the robot at rest
CalibrationResult calibrate(const std::vector<Scene>& scenes,
                            const PanTiltGeometry& geometry,
                            const CalibrationOptions& options = {});

}  // namespace marco::mapping3d
