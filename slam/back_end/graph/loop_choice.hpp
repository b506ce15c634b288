#pragma once

#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"

namespace marco::slam {

/// Chooses the loops of a graph that are inliers, and optimizes its poses for them: the truncated
/// least squares cost on loop edges. A loop is an inlier when it is no farther from what all the
/// rest says of its ends than both may be wrong, however far the rest gives in to it.
class LoopChoice {
 public:
  /// @param graph  its poses move; outlives the choice.
  LoopChoice(PoseGraph& graph, const PoseGraphOptions& options)
      : graph_(graph), options_(options) {}

  PoseGraphResult run();

 private:
  /// From loops chosen and poses optimized for them: takes out loops without which, and in loops
  /// with which the truncated cost is lower, until there are none.
  PoseGraphResult choose_loops(PoseGraphResult chosen, double limit);
  /// The loops after the next step of that; @param one_at_a_time  only the best one changes.
  std::vector<bool> better_choice(std::vector<bool> is_inlier,
                                  double limit,
                                  bool one_at_a_time) const;
  /// Starts without any loop and takes in one after the other.
  PoseGraphResult try_one_by_one();
  /// The truncated cost of these loops, poses optimized.
  static double choice_cost(const PoseGraphResult& result, double limit);
  /// No loop would be better out.
  bool all_agree(const PoseGraphResult& result) const;
  /// loop_rejection_chi2, or less where the loops show that the noise is less than their
  /// information claims.
  double limit_by_noise(const PoseGraphResult& result) const;
  /// Of each loop, by how much the error of all others grows when it is in force (to first order):
  /// its squared distance, in standard deviations, from what the others say. 3 degrees of freedom.
  std::vector<double> squared_mahalanobis_distances(const std::vector<bool>& is_inlier) const;
  PoseGraphResult optimize_trimmed(std::vector<double> weights, double slack);
  /// Weight 0 for loop edges that are off by more than `slack` times the limit, else 1.
  std::vector<double> fitting_edges(double slack) const;

  PoseGraph& graph_;
  const PoseGraphOptions& options_;
};

}  // namespace marco::slam
