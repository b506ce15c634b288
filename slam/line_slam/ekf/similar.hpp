#pragma once

#include <Eigen/Core>

namespace marco::slam {

/// Limits of `similar`, thesis A's alpha_max, d_err and d_inter.
struct SimilarOptions {
  double max_angle_rad = 0.0873;  ///< 5 deg
  double max_distance_m = 0.20;
  double min_overlap_m = 0.20;
};

/// A directed segment, free space on its left.
struct Segment {
  Eigen::Vector2d start_m;
  Eigen::Vector2d end_m;
};

/// Whether two walls may be the same one (thesis A, 5.1.1): their directions differ by less than
/// max_angle (walls are directed, so the two faces of a thin wall never meet) and both ends of one
/// lie within max_distance of the other segment, or one end does and the projection of its segment
/// overlaps the other by min_overlap. Symmetric. A wall shorter than min_overlap need only
/// be overlapped by its own length. Segments of no length are similar to nothing.
bool similar(const Segment& a, const Segment& b, const SimilarOptions& options);

/// Length of the overlap of `b` and the projection of `a` onto its line; negative = the gap between
/// them [m].
double overlap_m(const Segment& a, const Segment& b);

}  // namespace marco::slam
