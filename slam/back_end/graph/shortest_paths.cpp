#include "slam/back_end/graph/shortest_paths.hpp"

#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace marco::slam {

std::vector<double> shortest_path_lengths_m(int from,
                                            int node_count,
                                            const std::vector<PoseGraphEdge>& edges) {
  struct Step {
    int to;
    double length_m;
  };
  const auto count = static_cast<std::size_t>(node_count);
  std::vector<std::vector<Step>> steps(count);
  for (const PoseGraphEdge& edge : edges) {
    const double length_m = std::hypot(edge.from_from_to.x_m, edge.from_from_to.y_m);
    steps.at(static_cast<std::size_t>(edge.from)).push_back({edge.to, length_m});
    steps.at(static_cast<std::size_t>(edge.to)).push_back({edge.from, length_m});
  }
  std::vector<double> shortest_path_lengths_m(count, std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, int>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> reached;
  shortest_path_lengths_m.at(static_cast<std::size_t>(from)) = 0.0;
  reached.push({0.0, from});
  while (!reached.empty()) {
    const auto [way_m, node] = reached.top();
    reached.pop();
    if (way_m > shortest_path_lengths_m[static_cast<std::size_t>(node)]) continue;
    for (const Step& step : steps[static_cast<std::size_t>(node)]) {
      double& known_m = shortest_path_lengths_m[static_cast<std::size_t>(step.to)];
      if (way_m + step.length_m >= known_m) continue;
      known_m = way_m + step.length_m;
      reached.push({known_m, step.to});
    }
  }
  return shortest_path_lengths_m;
}

}  // namespace marco::slam
