#include "slam/back_end/graph/graduated_non_convexity.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

double first_mu(const std::vector<PoseGraphEdge>& edges,
                const std::vector<double>& chi2,
                double limit) {
  double worst = 0.0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].is_loop) worst = std::max(worst, chi2[i]);
  }
  return worst > limit ? limit / (2.0 * worst - limit) : 0.0;
}

bool graduate(const std::vector<PoseGraphEdge>& edges,
              const std::vector<double>& chi2,
              double limit,
              double mu,
              std::vector<double>& weights) {
  const double off_above = (mu + 1.0) / mu * limit, on_below = mu / (mu + 1.0) * limit;
  bool undecided = false;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!edges[i].is_loop) continue;
    weights[i] = chi2[i] >= off_above  ? 0.0
                 : chi2[i] <= on_below ? 1.0
                                       : std::sqrt(limit * mu * (mu + 1.0) / chi2[i]) - mu;
    undecided = undecided || (weights[i] > 0.01 && weights[i] < 0.99);
  }
  return undecided;
}

}  // namespace marco::slam
