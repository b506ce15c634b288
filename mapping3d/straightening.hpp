#pragma once

#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

struct StraighteningOptions {
  SurfelOptions surfels;
  double search_start_m = 0.3;  ///< a partner lies nearer, at first ...
  double search_end_m = 0.12;   ///< ... and in the end
  double lorentz_start_m = 0.05;
  double lorentz_end_m = 0.012;
  double shrink = 0.85;          ///< of both per iteration
  double max_normal_deg = 25.0;  ///< partners' normals differ less
  double thin_m = 0.005;         ///< a patch this thick counts half as much as a flat one
  double error_m = 0.01;         ///< of a few beams' mean from a patch that is where it belongs
  double row_error_deg = 1.2;    ///< how wrong a row's angle may be
  double row_step_deg = 0.6;     ///< the same from one row to the next; more is a jump
  double range_error_m = 0.03;   ///< how wrong the zero of the ranges may be
  double min_explained = 0.4;    ///< part of the squared distances; less is noise, and left alone
  double max_left = 0.75;        ///< part of the median distance that may be left; else as it was
  int iterations = 24;

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
    v("error_m", error_m, kPositive);
    v("row_error_deg", row_error_deg, kPositive);
    v("row_step_deg", row_step_deg, kPositive);
    v("range_error_m", range_error_m, kPositive);
    v("min_explained", min_explained, Limits{0.0, 1.0});
    v("max_left", max_left, Limits{0.0, 1.0});
    v("iterations", iterations, Limits{1, 1000});
  }
};

/// A line in space about which a sweep turns.
struct SweepAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit; zero where the sweep stands still
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};

/// The axis at a row, in the robot's frame, right-handed the way the sweep goes: from the poses of
/// the rows around it.
SweepAxis sweep_axis(const Scene& scene, std::size_t row);

/// By how much the rows of one scene were turned otherwise than they say: about the sweep's own
/// axis, positive the way the sweep went. Of a row whose sweep stands still: nothing.
using RowTurns = std::vector<double>;

/// Of the rows of all scenes together.
double rms_rad(const std::vector<RowTurns>& turns_rad);

struct Straightening {
  bool bent = false;       ///< otherwise nothing of the following differs from what was given
  double explained = 0.0;  ///< part of the squared distances that wrong rows explain
  std::vector<RowTurns> turns_rad;       ///< one a row, of each scene
  double turn_rms_rad = 0.0;             ///< of all rows
  double range_m = 0.0;                  ///< to be added to every range
  std::vector<Pose3> world_from_placed;  ///< one a scene
  double before_m = 0.0;                 ///< median distance of partners
  double after_m = 0.0;
};

/// The sweep with its rows where they were, and its ranges mended.
/// @param turns_rad  one a row
Scene straightened(const Scene& scene, const RowTurns& turns_rad, double range_m);

/// For a pan-tilt that does not go where it says (a servo that sticks and jumps, stamps that
/// waver) and a laser whose ranges begin elsewhere than at zero: finds each row's turn, one range
/// for all, and the bodies' poses together, from scenes that saw the same surfaces. Rows of beams
/// are laid on other scenes' patches, point to plane, by Gauss-Newton with the Lorentzian's weights
/// as in register_scenes(); neighbouring rows share their error but where it jumps (a Lorentzian on
/// their difference). Each step is solved by conjugate gradients. Rows that no other scene overlaps
/// go on as their neighbours do. An error that all scenes share at the same angles shows only as
/// far as they saw a surface from different places.
/// @param scenes             by the path
/// @param world_from_placed  one a scene, as registered: good to a few centimetres
/// @param body_of            as of register_scenes(); the first body stays where it is
/// @throws std::invalid_argument of other numbers
Straightening straighten(const std::vector<Scene>& scenes,
                         const RobotBox& robot,
                         const std::vector<Pose3>& world_from_placed,
                         const std::vector<std::size_t>& body_of,
                         const StraighteningOptions& options = {});

}  // namespace marco::mapping3d
