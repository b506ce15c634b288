#pragma once

#include <vector>

#include "common/triangle_mesh.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::mapping3d {

struct PlaneOptions {
  double cell_m = 0.10;      ///< size of the surface patches that form planes
  double max_turn_deg = 12;  ///< largest angle between a patch's normal and its plane's
  double max_gap_m = 0.04;   ///< largest distance of a patch from its plane
  double min_area_m2 = 0.3;  ///< of a plane
  double level_deg = 10.0;   ///< tolerance of floor, ceiling and wall from level or upright

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("max_gap_m", max_gap_m, kPositive,
               "Largest distance of a surface patch from its plane. More for noisy ranges.");
    v.advanced("min_area_m2", min_area_m2, kPositive, "Smaller planes are left out.");
  }
};

/// A flat part of the surface: n . x = offset, n towards the free side.
struct SurfacePlane {
  enum class Kind { floor, ceiling, wall, level, other };  ///< level: table tops

  Kind kind = Kind::other;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();   ///< in the plane, level where it can be
  Eigen::Vector3d across = Eigen::Vector3d::UnitY();  ///< normal x along
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();    ///< extent about the centre, along and across
  Eigen::Vector2d high_m = Eigen::Vector2d::Zero();
  double area_m2 = 0.0;  ///< of the surface that lies on it
  double rms_m = 0.0;    ///< of its patches
  /// Of (shift along the normal at the centre [m], slope along `along`, slope along `across`
  /// [rad]), with each patch as one measurement of the variance that the patches show.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Plane segmentation by region growing, largest first: patches join while normal and distance
/// agree, and coplanar parts (a wall left and right of a door) are merged. The floor is the largest
/// level plane that faces up and has at least half of the others above it.
/// @param mesh z up
std::vector<SurfacePlane> find_planes(const TriangleMesh& mesh, const PlaneOptions& options = {});

}  // namespace marco::mapping3d
