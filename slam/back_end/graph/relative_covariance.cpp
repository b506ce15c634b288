#include "slam/back_end/graph/relative_covariance.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <span>
#include <utility>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

double position_variance_m2(const Eigen::Matrix3d& covariance) {
  return covariance(0, 0) + covariance(1, 1);
}

// The edges that end at each node.
class EdgesOfNodes {
 public:
  EdgesOfNodes(std::size_t nodes, const std::vector<PoseGraphEdge>& edges)
      : first_(nodes + 1, 0), edges_(2 * edges.size()) {
    for (const PoseGraphEdge& edge : edges) {
      ++first_.at(static_cast<std::size_t>(edge.from) + 1);
      ++first_.at(static_cast<std::size_t>(edge.to) + 1);
    }
    for (std::size_t node = 0; node < nodes; ++node) first_[node + 1] += first_[node];
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t edge = 0; edge < edges.size(); ++edge) {
      edges_[next[static_cast<std::size_t>(edges[edge].from)]++] = edge;
      edges_[next[static_cast<std::size_t>(edges[edge].to)]++] = edge;
    }
  }
  std::span<const std::size_t> of(std::size_t node) const {
    return std::span(edges_).subspan(first_[node], first_[node + 1] - first_[node]);
  }

 private:
  std::vector<std::size_t> first_;  // of each node, in edges_
  std::vector<std::size_t> edges_;
};

}  // namespace

std::vector<RelativeUncertainty> relative_uncertainties(int node,
                                                        const std::vector<Pose2>& poses,
                                                        const std::vector<PoseGraphEdge>& edges,
                                                        double max_variance_m2) {
  const std::size_t count = poses.size();
  const auto at = [](int index) { return static_cast<std::size_t>(index); };
  const EdgesOfNodes edges_of(count, edges);
  const Eigen::Matrix3d beyond =
      diagonal_covariance(std::sqrt(max_variance_m2 / 2.0), std::numbers::pi);
  std::vector<RelativeUncertainty> result(count, {beyond, 0.0});
  std::vector<double> reached_m2(count, std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, int>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  result.at(at(node)).covariance.setZero();
  reached_m2[at(node)] = 0.0;
  queue.push({0.0, node});
  while (!queue.empty()) {
    const auto [variance_m2, near] = queue.top();
    queue.pop();
    if (variance_m2 > reached_m2[at(near)]) continue;
    for (const std::size_t index : edges_of.of(at(near))) {
      const PoseGraphEdge& edge = edges[index];
      const int far = edge.from == near ? edge.to : edge.from;
      // An edge's error stands in the frame of its `to`.
      const Pose2 node_from_to = between(poses[at(node)], poses[at(edge.to)]);
      const Eigen::Matrix3d covariance =
          result[at(near)].covariance + transformed(covariance_of(edge.information), node_from_to);
      const double far_m2 = position_variance_m2(covariance);
      if (far_m2 >= reached_m2[at(far)] || far_m2 > max_variance_m2) continue;
      result[at(far)] = {covariance,
                         result[at(near)].way_m + edge.from_from_to.translation_m().norm()};
      reached_m2[at(far)] = far_m2;
      queue.push({far_m2, far});
    }
  }
  return result;
}

}  // namespace marco::slam
