#include "slam/back_end/graph/shortest_paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace marco::slam {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

PoseGraphEdge edge(int from, int to, double length_m) {
  PoseGraphEdge edge;
  edge.from = from;
  edge.to = to;
  edge.from_from_to = {0.6 * length_m, -0.8 * length_m, 0.3};
  return edge;
}

TEST(Ways, ALoopIsAShortCut) {
  std::vector<PoseGraphEdge> edges;
  for (int i = 0; i < 9; ++i) edges.push_back(edge(i, i + 1, 1.0));
  EXPECT_NEAR(shortest_path_lengths_m(9, 11, edges)[0], 9.0, 1e-12);
  edges.push_back(edge(1, 9, 0.5));
  const std::vector<double> ways = shortest_path_lengths_m(9, 11, edges);
  EXPECT_NEAR(ways[0], 1.5, 1e-12);
  EXPECT_NEAR(ways[4], 3.5, 1e-12);
  EXPECT_NEAR(ways[6], 3.0, 1e-12);
  EXPECT_EQ(ways[10], kNone);
  EXPECT_THROW(shortest_path_lengths_m(0, 9, edges), std::out_of_range);
}

// The oracle: every edge is tried as often as there are nodes (Bellman and Ford).
TEST(Ways, AreThoseThatTryingEverythingFinds) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> length_m(0.0, 4.0);
  for (int world = 0; world < 20; ++world) {
    constexpr int kNodes = 60;
    std::vector<PoseGraphEdge> edges;
    for (int i = 0; i < 90; ++i) {
      edges.push_back(edge(static_cast<int>(random() % kNodes), static_cast<int>(random() % kNodes),
                           length_m(random)));
    }
    std::vector<double> expected(kNodes, kNone);
    expected[7] = 0.0;
    for (int round = 0; round < kNodes; ++round) {
      for (const PoseGraphEdge& one : edges) {
        const double step_m = std::hypot(one.from_from_to.x_m, one.from_from_to.y_m);
        double& from = expected[static_cast<std::size_t>(one.from)];
        double& to = expected[static_cast<std::size_t>(one.to)];
        from = std::min(from, to + step_m);
        to = std::min(to, from + step_m);
      }
    }
    const std::vector<double> ways = shortest_path_lengths_m(7, kNodes, edges);
    for (std::size_t node = 0; node < kNodes; ++node) {
      if (expected[node] == kNone) {
        EXPECT_EQ(ways[node], kNone);
      } else {
        EXPECT_NEAR(ways[node], expected[node], 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace marco::slam
