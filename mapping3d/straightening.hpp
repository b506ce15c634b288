#pragma once

#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/scene.hpp"
#include "mapping3d/surfel_matching.hpp"
#include "mapping3d/sweep_axis.hpp"

namespace marco::mapping3d {

struct StraighteningOptions {
  SurfelMatchingOptions matching{.surfels = {},
                                 .search_start_m = 0.3,
                                 .search_end_m = 0.12,
                                 .lorentz_start_m = 0.05,
                                 .lorentz_end_m = 0.012,
                                 .shrink = 0.85,
                                 .max_normal_deg = 25.0,
                                 .thin_m = 0.005};
  double error_m = 0.01;        ///< standard deviation of the mean of a few beams
  double row_error_deg = 1.2;   ///< prior standard deviation of a row's angle
  double row_step_deg = 0.6;    ///< the same from row to row; larger steps count as jumps
  double range_error_m = 0.03;  ///< prior standard deviation of the range offset
  double min_explained = 0.4;   ///< least part of the squared residuals that a step must explain
  double max_left = 0.75;       ///< largest part of the median residual that may remain
  int iterations = 24;
  /// Of a log of more than twice as many scenes these are looked at first: a faulty pan-tilt shows
  /// in a part of it, and all scenes of a long log would take as long as the rest of the model.
  std::size_t probed_scenes = 128;

  template <class Visitor>
  void visit(Visitor& v) {
    matching.visit(v);
    v("error_m", error_m, kPositive);
    v("row_error_deg", row_error_deg, kPositive);
    v("row_step_deg", row_step_deg, kPositive);
    v("range_error_m", range_error_m, kPositive);
    v("min_explained", min_explained, Limits{0.0, 1.0});
    v("max_left", max_left, Limits{0.0, 1.0});
    v("iterations", iterations, Limits{1, 1000});
  }
};

struct Straightening {
  bool bent = false;                ///< false: everything below is as it was given
  double explained = 0.0;           ///< part of the squared residuals that wrong row angles explain
  std::vector<RowTurns> turns_rad;  ///< one a row, of each scene
  double turn_rms_rad = 0.0;        ///< over all rows
  double range_m = 0.0;             ///< to be added to every range
  std::vector<Pose3> world_from_placed;  ///< one a scene
  double before_m = 0.0;                 ///< median residual
  double after_m = 0.0;
};

/// Deskews sweeps of a pan-tilt that does not follow its command (a servo that sticks and jumps,
/// jittering stamps) and of a laser with a range offset. Estimates each row's turn, one range
/// offset and the bodies' poses together, from scenes that saw the same surfaces: the beams of a
/// row are matched to the surfels of other scenes (point to plane) by Gauss-Newton with a robust
/// kernel, as in register_scenes(). Neighbouring rows share their error except where it jumps (a
/// Lorentzian on their difference); rows without overlap follow their neighbours. Each step is
/// solved by conjugate gradients. An error that all scenes have at the same angles can be observed
/// only where a surface was seen from different places.
/// @param scenes             on the path
/// @param world_from_placed  one a scene, as registered: good to a few centimetres
/// @param body_of            see register_scenes(); the first body is fixed
/// @throws std::invalid_argument when the numbers do not fit
Straightening straighten(const std::vector<Scene>& scenes,
                         const RobotBox& robot,
                         const std::vector<Pose3>& world_from_placed,
                         const std::vector<std::size_t>& body_of,
                         const StraighteningOptions& options = {});

}  // namespace marco::mapping3d
