#include "slam/back_end/loop_work.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// Squared Mahalanobis distance up to which a loop agrees with what is believed: 8 mm, as a loop's
// own uncertainty is 2 cm. (At 0.5 a building of two equal wings loses loops.) A larger graph,
// whose optimization costs more, lets more pass: up to 2 cm.
double agreement_limit_chi2(std::size_t keyframes) {
  constexpr double kAgrees = 0.15, kLarge = 2500.0, kMost = 1.0;  // see above; kLarge in keyframes
  return std::min(kMost, kAgrees * std::max(1.0, static_cast<double>(keyframes) / kLarge));
}

// The graph is optimized although all loops agree when they have grown by this part.
constexpr double kGrowth = 0.1;

// Whether that many more have come. A function of the two numbers: nothing needs to be remembered.
bool grew(std::size_t before, std::size_t after) {
  const auto steps = [](std::size_t count) {
    return std::floor(std::log1p(static_cast<double>(count)) / std::log1p(kGrowth));
  };
  return steps(after) > steps(before);
}

}  // namespace

void LoopWork::run() {
  const auto known = static_cast<std::size_t>(std::count_if(
      graph.edges().begin(), graph.edges().end(), [](const auto& edge) { return edge.is_loop; }));
  for (const LoopCandidate& candidate : candidates) {
    if (const auto loop = closer.verify(candidate)) found.push_back(*loop);
  }
  bool exceeds_threshold = false;
  for (const Loop& loop : found) {
    exceeds_threshold = exceeds_threshold ||
                        graph.edge_chi2(loop.edge()) > agreement_limit_chi2(graph.poses().size());
    graph.add_edge(loop.edge());
  }
  moved = robust || exceeds_threshold || grew(known, known + found.size());
  if (robust) {
    edge_is_inlier = graph.optimize_robustly().edge_is_inlier;
  } else if (moved) {
    graph.optimize_roughly();
  }
}

}  // namespace marco::slam
