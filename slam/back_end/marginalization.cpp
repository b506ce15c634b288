#include "slam/back_end/marginalization.hpp"

#include <algorithm>
#include <set>
#include <tuple>

namespace marco::slam {
namespace {

// A node takes over loops only up to this number: those of every visit would not end.
constexpr int kLoopsPerNode = 2;

// The edge seen from where the merged node is now; its error lives in the frame of `to`.
PoseGraphEdge moved_edge(PoseGraphEdge edge, int key, const MergedKeyframe& merged) {
  Eigen::Matrix3d covariance = covariance_of(edge.information);
  if (edge.from == key) {
    covariance += transformed(merged.covariance, edge.from_from_to.inverse());
    edge.from_from_to = merged.into_from_key * edge.from_from_to;
    edge.from = merged.into;
  } else {
    covariance = transformed(covariance + merged.covariance, merged.into_from_key);
    edge.from_from_to = edge.from_from_to * merged.into_from_key.inverse();
    edge.to = merged.into;
  }
  edge.information = information_of(covariance);
  return edge;
}

}  // namespace

void merge_nodes(int key,
                 const MergedKeyframe& merged,
                 std::vector<PoseGraphEdge>& edges,
                 std::vector<Loop>& loops) {
  using Pair = std::tuple<int, int, bool>;
  const auto pair_of = [](const PoseGraphEdge& edge) {
    return Pair{std::min(edge.from, edge.to), std::max(edge.from, edge.to), edge.is_loop};
  };
  // Only pairs with the node that stays can come twice.
  std::set<Pair> known;
  int loops_there = 0;
  for (const PoseGraphEdge& edge : edges) {
    if (edge.from != merged.into && edge.to != merged.into) continue;
    known.insert(pair_of(edge));
    loops_there += edge.is_loop ? 1 : 0;
  }
  const auto renumbered = [key](int node) { return node > key ? node - 1 : node; };
  std::vector<PoseGraphEdge> kept_edges;
  std::vector<Loop> kept_loops;
  kept_edges.reserve(edges.size());
  std::size_t next_loop = 0;
  for (PoseGraphEdge edge : edges) {
    const std::size_t loop_at = edge.is_loop ? next_loop++ : 0;
    if (edge.from == key || edge.to == key) {
      edge = moved_edge(edge, key, merged);
      if (edge.from == edge.to || !known.insert(pair_of(edge)).second) continue;
      if (edge.is_loop && ++loops_there > kLoopsPerNode) continue;
    }
    edge.from = renumbered(edge.from);
    edge.to = renumbered(edge.to);
    if (edge.is_loop) {
      Loop loop = loops[loop_at];
      loop.from = edge.from;
      loop.to = edge.to;
      loop.from_from_to = edge.from_from_to;
      loop.information = edge.information;
      kept_loops.push_back(loop);
    }
    kept_edges.push_back(edge);
  }
  edges = std::move(kept_edges);
  loops = std::move(kept_loops);
}

}  // namespace marco::slam
