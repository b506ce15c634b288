#include "slam/back_end/graph/loop_consistency.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

constexpr int kNear = 20;        // nodes between the ends of two loops that are compared
constexpr double kEnough = 0.4;  // share of the loops that must agree with another one

// The chain of consecutive nodes, and how uncertain it is from its start on.
struct Chain {
  std::vector<Pose2> poses;
  std::vector<double> turn_variance, shift_variance;  // summed along the way

  Chain(std::size_t nodes, const std::vector<PoseGraphEdge>& edges)
      : poses(nodes), turn_variance(nodes, 0.0), shift_variance(nodes, 0.0) {
    std::vector<const PoseGraphEdge*> to_next(nodes, nullptr);
    for (const PoseGraphEdge& edge : edges) {
      if (edge.to == edge.from + 1 && !edge.is_loop) {
        to_next[static_cast<std::size_t>(edge.from)] = &edge;
      }
    }
    for (std::size_t i = 0; i + 1 < nodes; ++i) {
      const PoseGraphEdge* edge = to_next[i];
      poses[i + 1] = edge == nullptr ? poses[i] : poses[i] * edge->from_from_to;
      turn_variance[i + 1] = turn_variance[i] + turn_variance_of(edge);
      shift_variance[i + 1] = shift_variance[i] + shift_variance_of(edge);
    }
  }
  static double turn_variance_of(const PoseGraphEdge* edge) {
    return edge == nullptr ? 1e6 : 1.0 / edge->information(2, 2);
  }
  static double shift_variance_of(const PoseGraphEdge* edge) {
    return edge == nullptr ? 1e6 : 1.0 / edge->information(0, 0) + 1.0 / edge->information(1, 1);
  }
};

// Whether two loops and the ways between their ends, a short cycle, lead back to the start.
bool agree(const Chain& chain, const PoseGraphEdge& a, const PoseGraphEdge& b) {
  constexpr double kLimit = 9.0;  // 3 sigma
  const auto at = [](int node) { return static_cast<std::size_t>(node); };
  const Pose2 old_step = between(chain.poses[at(a.from)], chain.poses[at(b.from)]);
  const Pose2 new_step = between(chain.poses[at(a.to)], chain.poses[at(b.to)]);
  const Pose2 cycle = between(a.from_from_to * new_step, old_step * b.from_from_to);
  const double way_turn =
      std::abs(chain.turn_variance[at(a.from)] - chain.turn_variance[at(b.from)]) +
      std::abs(chain.turn_variance[at(a.to)] - chain.turn_variance[at(b.to)]);
  const double turn = way_turn + Chain::turn_variance_of(&a) + Chain::turn_variance_of(&b);
  const double lever2 = old_step.translation_m().squaredNorm() +
                        new_step.translation_m().squaredNorm() +
                        b.from_from_to.translation_m().squaredNorm();
  const double shift =
      std::abs(chain.shift_variance[at(a.from)] - chain.shift_variance[at(b.from)]) +
      std::abs(chain.shift_variance[at(a.to)] - chain.shift_variance[at(b.to)]) +
      Chain::shift_variance_of(&a) + Chain::shift_variance_of(&b) + turn * lever2;
  return cycle.theta_rad * cycle.theta_rad < kLimit * turn &&
         cycle.translation_m().squaredNorm() < kLimit * shift;
}

struct Loop {
  PoseGraphEdge edge;  // from the older node
  std::size_t index;
};

// The loop edges, by their older node.
std::vector<Loop> loops_among(const std::vector<PoseGraphEdge>& edges) {
  std::vector<Loop> loops;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    PoseGraphEdge edge = edges[i];
    if (!edge.is_loop) continue;
    if (edge.from > edge.to) {
      std::swap(edge.from, edge.to);
      edge.from_from_to = edge.from_from_to.inverse();
    }
    loops.push_back({edge, i});
  }
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
    return a.edge.from != b.edge.from ? a.edge.from < b.edge.from : a.index < b.index;
  });
  return loops;
}

}  // namespace

std::vector<double> consistent_loops(std::size_t nodes, const std::vector<PoseGraphEdge>& edges) {
  const Chain chain(nodes, edges);
  const std::vector<Loop> loops = loops_among(edges);
  std::vector<double> weights(edges.size(), 1.0);
  for (const Loop& loop : loops) weights[loop.index] = 0.0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    for (std::size_t k = i + 1;
         k < loops.size() && loops[k].edge.from - loops[i].edge.from <= kNear; ++k) {
      if (std::abs(loops[k].edge.to - loops[i].edge.to) > kNear) continue;
      if (agree(chain, loops[i].edge, loops[k].edge)) {
        weights[loops[i].index] = weights[loops[k].index] = 1.0;
      }
    }
  }
  const auto count = std::count_if(loops.begin(), loops.end(),
                                   [&](const Loop& loop) { return weights[loop.index] > 0.0; });
  if (static_cast<double>(count) < kEnough * static_cast<double>(loops.size())) {
    std::fill(weights.begin(), weights.end(), 1.0);
  }
  return weights;
}

}  // namespace marco::slam
