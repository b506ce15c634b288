#pragma once

#include <Eigen/Core>
#include <vector>

namespace marco::plan {

/// A stretch between two points that is straight or an arc, by its bulge, as DXF's polylines have
/// it: the tangent of a quarter of the angle that it turns by, above 0 counter-clockwise; 0 is
/// straight, 1 half a circle.
double bulge_of(double turn_rad);

/// The arc of a bulge other than 0.
struct BulgeArc {
  Eigen::Vector2d centre;
  double radius;                          ///< in the points' unit
  double from_rad;                        ///< direction from the centre to the first point
  double turn_rad;                        ///< to the second one, above 0 counter-clockwise
  Eigen::Vector2d at(double part) const;  ///< 0 is the first point, 1 the second
};
BulgeArc bulge_arc(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double bulge);

/// Length along the stretch, in the points' unit.
double bulge_length_m(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double bulge);

/// Area between the stretch and its chord, above 0 where the arc lies on the right of from -> to:
/// what a loop that runs counter-clockwise gains.
double bulge_area_m2(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double bulge);

/// The stretch as a chain of points without its last one, no farther than `near` from it.
std::vector<Eigen::Vector2d> bulge_points(const Eigen::Vector2d& from,
                                          const Eigen::Vector2d& to,
                                          double bulge,
                                          double near = 0.001);

}  // namespace marco::plan
