#include "slam/doctor/known_by_loops.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "slam/back_end/graph/edge_judgement.hpp"

namespace marco::slam {
namespace {

int nearest_key(const std::vector<Keyframe>& keys, Utime utime) {
  const auto off_s = [utime](const Keyframe& key) {
    return std::abs((key.utime - utime).seconds());
  };
  const auto found = std::min_element(
      keys.begin(), keys.end(), [&](const auto& a, const auto& b) { return off_s(a) < off_s(b); });
  return static_cast<int>(found - keys.begin());
}

}  // namespace

KnownByLoops known_by_loops(const MapEvidence& map, Utime from, Utime to) {
  // Not 0, so that what hangs by these steps alone does not hang in the air.
  constexpr double kHardlyAtAll = 1e-6;
  if (map.edges.empty()) return {};
  int first = nearest_key(map.keys, from), last = nearest_key(map.keys, to);
  if (first > last) std::swap(first, last);
  if (first == last) return {};
  const auto within = [&](int key) { return key >= first && key <= last; };
  PoseGraph graph;
  for (const Keyframe& key : map.keys) graph.add_node(key.world_from_robot);
  std::vector<double> weights;
  std::size_t loop = 0;
  for (const PoseGraphEdge& edge : map.edges) {
    graph.add_edge(edge);
    const bool refused = edge.is_loop && !map.loops[loop++].is_inlier;
    weights.push_back(refused ? 0.0 : within(edge.from) && within(edge.to) ? kHardlyAtAll : 1.0);
  }
  const Eigen::Matrix3d covariance = relative_covariance(graph, weights, first, last);
  const double m2 = covariance.topLeftCorner<2, 2>().trace(), rad2 = covariance(2, 2);
  KnownByLoops known;
  if (m2 >= 0.0) known.sigma_m = std::sqrt(m2);
  if (rad2 >= 0.0) known.sigma_rad = std::sqrt(rad2);
  return known;
}

}  // namespace marco::slam
