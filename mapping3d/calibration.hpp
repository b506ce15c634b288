#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/input/pantilt_correction.hpp"
#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surfel_matching.hpp"

namespace marco::mapping3d {

struct PanTiltGeometry {
  SensorInfo base;
  SensorInfo sensor;
};

struct CalibrationOptions {
  SurfelMatchingOptions matching{.surfels = {},
                                 .search_start_m = 0.6,
                                 .search_end_m = 0.15,
                                 .lorentz_start_m = 0.1,
                                 .lorentz_end_m = 0.015,
                                 .shrink = 0.6,
                                 .max_normal_deg = 30.0,
                                 .thin_m = 0.003};
  double prior_m = 0.1;      ///< prior standard deviation of lengths ...
  double prior_deg = 5.0;    ///< ... of angles ...
  double prior_s = 0.1;      ///< ... and of times; an unobservable parameter keeps its value
  double same_stop_m = 0.1;  ///< scenes farther apart are not compared: they have the path's error
  int max_iterations = 30;

  template <class Visitor>
  void visit(Visitor& v) {
    matching.visit(v);
    v("prior_m", prior_m, kPositive);
    v("prior_deg", prior_deg, kPositive);
    v("prior_s", prior_s, kPositive);
    v("same_stop_m", same_stop_m, kPositive);
    v("max_iterations", max_iterations, Limits{1, 1000});
  }
};

struct CalibrationResult {
  enum class Status { converged, not_converged, nothing_seen_twice };
  Status status = Status::nothing_seen_twice;
  PanTiltCorrection found;       ///< of the given geometry
  PanTiltCorrection correction;  ///< the same, or none where it may be chance as a whole
  PanTiltCorrection sigma;       ///< standard deviations; near the prior where unobservable
  std::size_t pairs = 0;         ///< correspondences
  double before_m = 0.0;         ///< median residual with the given geometry
  double after_m = 0.0;
};

/// e.g. "no surface seen twice"
std::string to_string(CalibrationResult::Status status);

/// Calibration of a laser on a pan-tilt: estimates lever arms, axis offsets, zero angles and
/// how late the angles are (best where sweeps go both ways) by letting planes
/// that sweeps of one stop saw twice (at several pans, or by tilt and by pan) coincide.
/// Gauss-Newton as in register_scenes(), with the geometry as the unknown and derivatives by
/// central differences. Converges from about 5 deg and 5 cm.
/// @param scenes  rows with their pan and tilt angles; the robot stands still in each
CalibrationResult calibrate(const std::vector<Scene>& scenes,
                            const PanTiltGeometry& geometry,
                            const CalibrationOptions& options = {});

}  // namespace marco::mapping3d
