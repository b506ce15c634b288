#pragma once

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::slam {

/// Points with surface normals.
struct OrientedPoints {
  Points2 points;   ///< 2xN [m]
  Points2 normals;  ///< 2xN unit, towards the sensor; (0, 0) where the neighbours form no line
  double range_sigma_m = 0.0;  ///< noise of the ranges; 0 = not known

  bool has_normal(Eigen::Index i) const { return normals(0, i) != 0.0 || normals(1, i) != 0.0; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("points", points);
    v("normals", normals);
    v("range_sigma_m", range_sigma_m);
  }
};

/// How normals are estimated where ranges are precise. From about 1 cm of noise on the
/// neighbourhood grows with it, or the normals would be noise: a normal is off by sigma sqrt(12/n)
/// / length.
struct NormalOptions {
  int neighbours = 5;           ///< at most, on each side
  double radius_m = 0.25;       ///< of the neighbourhood; the next beam may lie farther
  double gap_m = 0.30;          ///< the next beam belongs to it up to this distance ...
  double gap_per_range = 0.10;  ///< ... or this part of the range, for far walls
  double max_rms_m = 0.03;      ///< of the neighbours about their line

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("neighbours", neighbours, Limits{1, 50},
               "A normal is fitted to at most this many points on each side. Less for lasers with "
               "few beams.");
    v.advanced("radius_m", radius_m, kPositive,
               "Neighbours lie within this distance. Less for short walls, more for noisy ranges.");
    v.advanced("gap_m", gap_m, kPositive,
               "Neighbouring returns farther apart than this lie on different walls.");
  }
};

/// Estimates each point's normal from its neighbours in the scan by principal components, as thesis
/// B's calculated points (app. E.20-30), but with neighbours chosen by distance.
/// @param points  2xN [m] in the order of the beams
/// @param sensor  [m] where the beams came from, same frame
/// @param range_sigma_m  noise of the ranges; 0 = not known
/// Cost O(N · neighbours).
OrientedPoints orient(const Points2& points,
                      const Eigen::Vector2d& sensor,
                      const NormalOptions& options,
                      double range_sigma_m = 0.0);

}  // namespace marco::slam
