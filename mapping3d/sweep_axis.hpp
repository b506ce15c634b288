#pragma once

#include <vector>

#include "common/pose3.hpp"
#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// The axis in space about which a sweep turns.
struct SweepAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit; zero where the sweep stands still
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};

/// The axis at a row, robot frame, right-handed in the direction of the sweep: from the poses of
/// the rows around it.
SweepAxis sweep_axis(const Scene& scene, std::size_t row);

/// Corrections of a scene's row angles: about the sweep's axis, positive in the direction of the
/// sweep. Without effect on a row whose sweep stands still.
using RowTurns = std::vector<double>;

/// Over the rows of all scenes.
double rms_rad(const std::vector<RowTurns>& turns_rad);

/// The sweep with corrected rows and ranges.
/// @param turns_rad  one a row
Scene straightened(const Scene& scene, const RowTurns& turns_rad, double range_m);

}  // namespace marco::mapping3d
