#include "slam/back_end/graph/map_spread.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/covariance.hpp"
#include "common/rigid_fit.hpp"

namespace marco::slam {
namespace {

constexpr int kNodes = 40;
constexpr double kStepM = 0.05, kStepRad = 0.01, kPart = 0.1;

// A round of steps of 1 m, and a loop that closes it.
PoseGraph round_of_steps(std::mt19937* random) {
  std::normal_distribution<double> normal;
  const auto measured = [&](const Pose2& truth) {
    if (random == nullptr) return truth;
    return Pose2{truth.x_m + kStepM * normal(*random), truth.y_m + kStepM * normal(*random),
                 truth.theta_rad + kStepRad * normal(*random)};
  };
  const Eigen::Matrix3d information = information_of(diagonal_covariance(kStepM, kStepRad));
  const Pose2 step{1.0, 0.0, 2.0 * std::numbers::pi / kNodes};
  PoseGraph graph;
  Pose2 pose;
  for (int i = 0; i < kNodes; ++i) {
    graph.add_node(pose);
    if (i > 0) graph.add_edge({i - 1, i, measured(step), information, false});
    pose = pose * step;
  }
  graph.add_edge({kNodes - 1, 0, measured(step), information, true});
  return graph;
}

Eigen::Matrix2Xd places(const PoseGraph& graph) {
  Eigen::Matrix2Xd result(2, kNodes);
  for (int i = 0; i < kNodes; ++i)
    result.col(i) = graph.poses()[static_cast<std::size_t>(i)].translation_m();
  return result;
}

// The slow way: measure again, solve, lay on the truth, sort.
double spread_by_trials(const std::vector<double>& weights) {
  constexpr int kTrials = 300;
  std::mt19937 random(7);
  const Eigen::Matrix2Xd truth = places(round_of_steps(nullptr));
  std::vector<double> spreads;
  for (int trial = 0; trial < kTrials; ++trial) {
    PoseGraph graph = round_of_steps(&random);
    graph.optimize_weighted(weights, 1e-9);
    const Eigen::Matrix2Xd drawn = places(graph);
    const Eigen::VectorXd off = distances_after_fit(drawn, truth);
    std::vector<double> sorted(off.begin(), off.end());
    std::sort(sorted.begin(), sorted.end());
    spreads.push_back(sorted[static_cast<std::size_t>((1.0 - kPart) * (kNodes - 1))]);
  }
  std::sort(spreads.begin(), spreads.end());
  return spreads[spreads.size() / 2];
}

TEST(MapSpread, IsThatOfMapsMeasuredAgain) {
  const PoseGraph graph = round_of_steps(nullptr);
  for (const double loop : {1.0, 0.0}) {
    std::vector<double> weights(kNodes, 1.0);
    weights.back() = loop;
    const double expected = spread_by_trials(weights);
    EXPECT_NEAR(map_spread_m(graph, weights, kPart), expected, 0.2 * expected) << loop;
  }
}

TEST(MapSpread, IsTheSameInEveryRunAndInfiniteWhereAPartHangsInTheAir) {
  const PoseGraph graph = round_of_steps(nullptr);
  std::vector<double> weights(kNodes, 1.0);
  EXPECT_EQ(map_spread_m(graph, weights, kPart), map_spread_m(graph, weights, kPart));
  weights[10] = weights[20] = 0.0;
  EXPECT_TRUE(std::isinf(map_spread_m(graph, weights, kPart)));
}

}  // namespace
}  // namespace marco::slam
