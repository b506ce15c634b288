#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "common/pose2.hpp"

namespace marco::slam {

/// The standard deviation of a scan's ranges [m], from how far each point lies along its beam from
/// the line through its two neighbours: on a straight wall that is noise alone, at any incidence
/// and any spacing of the beams. The median over all points, so that corners and clutter, less than
/// half of them, do not count.
/// @param points  2xN [m] in the order of the beams; @param sensor  [m], same frame
/// @returns nothing where too few points have neighbours on their wall. Cost O(N).
std::optional<double> range_sigma_of(const Points2& points, const Eigen::Vector2d& sensor);

/// The noise of a laser's ranges, learned from its scans: the median over the last ones. A value:
/// its fields are its state.
struct RangeNoise {
  std::deque<double> sigmas_m;  ///< of the last scans, oldest first

  void add(const Points2& points, const Eigen::Vector2d& sensor);
  /// 0 until a scan has shown it.
  double sigma_m() const;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigmas_m", sigmas_m);
  }
};

}  // namespace marco::slam
