#pragma once

#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "slam/back_end/graph/pose_graph.hpp"
#include "slam/back_end/graph/robust_start.hpp"

namespace marco::slam::testing {

/// A graph of SE2 vertices and edges; an edge that is not to the next node is a loop.
inline PoseGraph read_g2o(const std::string& path) {
  PoseGraph graph;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string kind;
    fields >> kind;
    if (kind == "VERTEX_SE2") {
      int id = 0;
      Pose2 pose;
      fields >> id >> pose.x_m >> pose.y_m >> pose.theta_rad;
      graph.add_node(pose);
    } else if (kind == "EDGE_SE2") {
      PoseGraphEdge edge;
      Eigen::Matrix3d& o = edge.information;
      fields >> edge.from >> edge.to >> edge.from_from_to.x_m >> edge.from_from_to.y_m >>
          edge.from_from_to.theta_rad >> o(0, 0) >> o(0, 1) >> o(0, 2) >> o(1, 1) >> o(1, 2) >>
          o(2, 2);
      o = Eigen::Matrix3d(o.selfadjointView<Eigen::Upper>());
      edge.is_loop = edge.to != edge.from + 1;
      graph.add_edge(edge);
    }
  }
  return graph;
}

/// Poses computed from the edges alone, however wrong they are now.
inline void initialize_from_edges(PoseGraph& graph) {
  const RobustStart start = robust_start(graph.poses().front(), graph.node_count(), graph.edges(),
                                         std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < start.poses.size(); ++i) {
    graph.set_pose(static_cast<int>(i), start.poses[i]);
  }
}

/// Each node where the edges from one to the next lead.
inline void place_along_odometry(PoseGraph& graph) {
  for (const PoseGraphEdge& edge : graph.edges()) {
    if (edge.is_loop) continue;
    const Pose2 from = graph.poses()[static_cast<std::size_t>(edge.from)];
    graph.set_pose(edge.to, from * edge.from_from_to);
  }
}

/// Loops between random nodes that claim a random pose within 1 m and any turn, as sure of
/// themselves as some right loop of the graph.
inline void add_wrong_loops(PoseGraph& graph, int count, std::mt19937& random) {
  std::vector<Eigen::Matrix3d> information_matrices;
  for (const PoseGraphEdge& edge : graph.edges()) {
    if (edge.is_loop) information_matrices.push_back(edge.information);
  }
  std::uniform_real_distribution<double> offset_m(-1.0, 1.0), turn_rad(-3.14, 3.14);
  while (count > 0) {
    PoseGraphEdge edge;
    edge.from = static_cast<int>(random() % graph.node_count());
    edge.to = static_cast<int>(random() % graph.node_count());
    if (std::abs(edge.from - edge.to) < 2) continue;
    edge.from_from_to = {offset_m(random), offset_m(random), turn_rad(random)};
    edge.information = information_matrices[random() % information_matrices.size()];
    edge.is_loop = true;
    graph.add_edge(edge);
    --count;
  }
}

}  // namespace marco::slam::testing
