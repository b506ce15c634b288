#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping3d/clouds/scan_lines.hpp"

namespace marco::mapping3d {

/// Where a scanner saw a point, in its own frame.
struct ScanDirection {
  uint32_t point;  ///< index in the cloud
  float range_m;
  double azimuth_rad;  ///< from the first column on, 0 .. 2 pi
  double elevation_rad;

  /// From the axis of the azimuths.
  double level_m() const { return static_cast<double>(range_m) * std::cos(elevation_rad); }
};

struct ScanDirections {
  std::vector<ScanDirection> seen;
  double width_rad = 0.0;  ///< of the azimuths
};

/// The directions of points that are finite and farther off than 5 cm. The first column lies after
/// the widest gap between azimuths, so that a scan of less than all around is not cut in two.
ScanDirections directions_of(const std::vector<Eigen::Vector3f>& points_m);

/// Rows and columns for these directions.
struct DirectionLattice {
  ScanLines rows;  ///< elevations
  ScanLines columns;
  bool is_even = false;  ///< the rows or the columns are no lines of the scanner's
};

/// 0.2 deg all around; a wall at 7 m then has a point in each voxel of 2.5 cm.
inline constexpr std::size_t kMostCells = 2'000'000;

/// The scanner's own lines where it has any, else even steps by how densely the points lie; thinned
/// out to kMostCells. @pre there is a direction
DirectionLattice lattice_of(const ScanDirections& directions);

}  // namespace marco::mapping3d
