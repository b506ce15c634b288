#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "slam/line_slam/ekf/ekf_state.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"

namespace marco::slam {

/// A possible pairing of data association: an observation with a wall of the map.
struct Candidate {
  int observation = 0;
  int wall = 0;     ///< the caller's number for it
  SparseRows rows;  ///< two rows, at the state the test is about
};

/// The upper `probability` point of the chi-square distribution (Wilson and Hilferty 1931; within
/// 1 % for 2 degrees of freedom and more).
double chi_square_limit(int degrees_of_freedom, double probability);

/// Squared Mahalanobis distance of one pairing (individual compatibility).
double individual_distance2(const EkfState& state, const Candidate& candidate);

/// The same of any filter: a possible pairing of an observation, by its innovation.
struct Pairing {
  static constexpr int kAnyTimes = -1;
  int observation = 0;
  int only_once = kAnyTimes;  ///< of pairings with one number here, a set holds one at most
  Eigen::Vector2d innovation;
  Eigen::Matrix2d covariance;  ///< of the innovation, with noise
  double distance2 = 0.0;      ///< squared Mahalanobis distance of this pairing alone
};
/// Covariance of two pairings' innovations, by their indices.
using CrossCovariance = std::function<Eigen::Matrix2d(int a, int b)>;

/// Joint compatibility branch and bound (JCBB; Neira and Tardos, IEEE T-RA 2001, fig. 3): the
/// largest set of pairings, at most one per observation, whose joint innovation passes the gate;
/// among sets of one size the nearest.
/// @param probability  of keeping a true set, for each number of pairings.
/// @returns per observation the index of its candidate, or -1.
/// Cost O(pairings^2) where first choices agree; stops branching after 2000 nodes.
std::vector<int> joint_compatibility(const std::vector<Pairing>& candidates,
                                     const CrossCovariance& cross_covariance,
                                     int num_observations,
                                     double probability);

/// As above, of walls. What differs from the paper: a wall may be paired more than once, because
/// occlusion cuts one wall into several.
std::vector<int> joint_compatibility(const EkfState& state,
                                     const std::vector<Candidate>& candidates,
                                     int num_observations,
                                     double probability);

}  // namespace marco::slam
