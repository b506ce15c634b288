#pragma once

#include <Eigen/Core>
#include <vector>

#include "slam/line_slam/ekf/compressed_state.hpp"
#include "slam/line_slam/ekf/sparse_rows.hpp"

namespace marco::slam {

/// A pairing that might be: an observation with a wall of the map.
struct Candidate {
  int observation = 0;
  int wall = 0;     ///< the caller's number for it
  SparseRows rows;  ///< two rows, at the state the test is about
};

/// The upper `probability` point of the chi-square distribution (Wilson and Hilferty 1931; within
/// 1 % for 2 degrees of freedom and more).
double chi_square_limit(int degrees_of_freedom, double probability);

/// Squared Mahalanobis distance of one pairing.
double individual_distance2(const CompressedState& state, const Candidate& candidate);

/// Joint compatibility branch and bound (Neira and Tardos 2001): the largest set of pairings, one
/// at most an observation, whose innovations fit together under the joint covariance; of equal ones
/// the nearest. Walls may be paired more than once: occlusion cuts one wall into several.
/// @param probability  of keeping a true set, for each number of pairings.
/// @returns per observation the index of its candidate, or -1.
/// Cost O(pairings^2) where first choices agree; stops branching after 2000 nodes.
std::vector<int> joint_compatibility(const CompressedState& state,
                                     const std::vector<Candidate>& candidates,
                                     int num_observations,
                                     double probability);

}  // namespace marco::slam
