#pragma once

#include <vector>

#include "common/pose2.hpp"
#include "slam/back_end/graph/pose_graph.hpp"

namespace marco::slam {

struct JointRefinementOptions {
  int max_iterations = 6;
  double first_reach_m = 0.15;  ///< how far a point looks for its partner at first
  double last_reach_m = 0.08;   ///< and in the end
  double sigma_m =
      0.03;  ///< of the Lorentzian: a larger distance across a wall counts less and less
  int every_nth_point = 6;       ///< looks for partners; another of each n at each iteration
  int partners = 6;              ///< scans in which a point may have a correspondence at once
  double normal_limit_deg = 30;  ///< partners' walls face the same way within this
  double stop_below_m = 2e-4;    ///< largest move of an iteration at which it ends
};

/// The same where ranges are as noisy as this: partners are sought farther off, and errors count
/// longer.
JointRefinementOptions adapted(JointRefinementOptions options, double range_sigma_m);

/// A keyframe's points that lie on something smooth, with the way it faces.
struct OrientedScan {
  Points2 points_in_robot;   ///< 2xN [m]
  Points2 normals_in_robot;  ///< 2xN, unit length, towards the sensor
};

struct JointRefinementResult {
  bool converged = false;
  int iterations = 0;
  double rms_m = 0.0;  ///< of the weighted distances across the walls, at the end
  std::int64_t ties = 0;
};

/// Moves all keyframes at once so that each lies best on all its neighbours: for every point its
/// nearest partners in other scans, the distance across the partner's wall, the Lorentzian, one
/// sparse Gauss-Newton step over all poses; again with new partners (the idea of Lu & Milios 1997,
/// with points on lines in place of their pairwise pose differences, and thesis B's estimator).
/// Partners are sought among at most 16 points of each cell, evenly taken from all that lie there:
/// the nearest of hundreds is the one whose noise agrees, and would hold a scan where it is; and so
/// the cost of a point does not grow with how often its wall was seen. Node 0 stays. Deterministic.
/// @returns the refined poses through `poses`.
/// @throws std::invalid_argument when there is not one scan a pose, or a point is not finite.
JointRefinementResult refine_jointly(const std::vector<OrientedScan>& scans,
                                     const std::vector<PoseGraphEdge>& edges,
                                     const JointRefinementOptions& options,
                                     std::vector<Pose2>& poses);

}  // namespace marco::slam
