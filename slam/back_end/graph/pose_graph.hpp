#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "common/covariance.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/back_end/graph/pose_graph_edge.hpp"

namespace marco::slam {

struct PoseGraphOptions {
  int max_iterations = 100;
  double min_relative_decrease = 1e-9;    ///< of the error, at which it has converged
  double rough_relative_decrease = 1e-3;  ///< the same for optimize_roughly
  /// A loop edge whose e^T Omega e ends above this is an outlier.
  double loop_rejection_chi2 = 16.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("loop_rejection_chi2", loop_rejection_chi2, kPositive,
               "Loop closures that contradict the rest of the graph by more are rejected "
               "(chi-squared with 3 degrees of freedom: 16.3 is 0.1 %).");
  }
};

struct PoseGraphResult {
  bool converged = false;
  int iterations = 0;
  double chi2 = 0.0;                 ///< sum of e^T Omega e over the edges in force, no 1/2
  std::vector<bool> edge_is_inlier;  ///< one an edge: false = a loop edge taken for wrong
};

/// The pose graph: keyframe poses and measurements between them with their information matrices;
/// node 0 stays where it is.
///
/// Error of an edge, in the measurement's frame: e = (R_z^T (R_i^T (t_j - t_i) - t_z), theta_j -
/// theta_i - theta_z) (Kuemmerle et al., g2o, ICRA 2011, SE2 edges). Solved by Gauss-Newton with
/// Levenberg's damping on the sparse normal equations (Eigen's LDL^T); after a step that turned
/// much, the translations are solved given the headings, a linear problem (variable projection,
/// Golub & Pereyra 1973). Wrong loops: the truncated least squares cost on loop edges, started by
/// graduated non-convexity (robust_start.hpp). Not thread-safe; a copy may be optimized on another
/// thread.
class PoseGraph {
 public:
  explicit PoseGraph(const PoseGraphOptions& options = {});

  /// @returns the node's index.
  int add_node(const Pose2& world_from_node);

  /// @throws std::invalid_argument for a node that does not exist, an edge from a node to itself,
  /// a measurement that is not finite, information that is not positive semidefinite.
  void add_edge(const PoseGraphEdge& edge);

  /// Without a node, those after it move up; all edges are forgotten.
  void remove_node(int node);

  std::size_t node_count() const { return poses_.size(); }
  const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  const std::vector<Pose2>& poses() const { return poses_; }
  void set_pose(int node, const Pose2& world_from_node) {
    poses_.at(static_cast<std::size_t>(node)) = world_from_node;
  }
  /// @param world_from_nodes  one a node
  void set_poses(std::vector<Pose2> world_from_nodes) { poses_ = std::move(world_from_nodes); }

  /// Moves the poses to the optimum near where they are; all edges count fully.
  PoseGraphResult optimize();

  /// The same, ended earlier: for poses that the next loop will move again.
  PoseGraphResult optimize_roughly();

  /// As optimize; the edges count by their weights, one an edge, 0 = not at all.
  PoseGraphResult optimize_weighted(const std::vector<double>& weights,
                                    double min_relative_decrease);

  /// As optimize, but loop edges may be found wrong and switched off: from where the poses are and,
  /// unless all loops agree there, from robust_start() too, and few loops one after the other from
  /// none on; the lower truncated cost wins (LoopChoice).
  PoseGraphResult optimize_robustly();

  /// Adds all edges, by their weights, to normal equations at the present poses.
  void fill(SparseNormalEquations& equations,
            const std::vector<double>& weights,
            Moves moves) const;

  /// Sum of e^T Omega e of all edges at the present poses.
  double chi2() const;
  /// e^T Omega e of one edge at the present poses.
  double edge_chi2(const PoseGraphEdge& edge) const;

 private:
  /// Where the headings put the translations: a linear problem, solved exactly. A turn bends the
  /// way of all nodes behind it, and without this steps along it stay tiny.
  /// @param error  at the present poses. @returns the error afterwards, never a larger one.
  double settle_translations(const std::vector<double>& weights, double error);
  double weighted_chi2(const std::vector<double>& weights) const;

  PoseGraphOptions options_;
  std::vector<Pose2> poses_;
  std::vector<PoseGraphEdge> edges_;
};

}  // namespace marco::slam
