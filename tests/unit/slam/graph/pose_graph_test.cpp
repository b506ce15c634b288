#include "slam/graph/pose_graph.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/support/g2o_graph.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// A square of 4 x `side` steps of 1 m, closed, measured without error.
PoseGraph square(int side, std::vector<Pose2>& truth) {
  PoseGraph graph;
  Pose2 pose;
  const int nodes = 4 * side;
  for (int i = 0; i < nodes; ++i) {
    truth.push_back(pose);
    graph.add_node(pose);
    pose = pose * Pose2{1.0, 0.0, (i + 1) % side == 0 ? std::numbers::pi / 2 : 0.0};
  }
  const Eigen::Matrix3d information = 1e4 * Eigen::Matrix3d::Identity();
  for (int i = 0; i + 1 < nodes; ++i) {
    const auto at = static_cast<std::size_t>(i);
    graph.add_edge({i, i + 1, between(truth[at], truth[at + 1]), information});
  }
  graph.add_edge({nodes - 1, 0, between(truth.back(), truth.front()), information, true});
  return graph;
}

void disturb(PoseGraph& graph, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  for (std::size_t i = 1; i < graph.node_count(); ++i) {
    const Pose2 pose = graph.poses()[i];
    graph.set_pose(static_cast<int>(i), {pose.x_m + noise(random), pose.y_m + noise(random),
                                         pose.theta_rad + 0.3 * noise(random)});
  }
}

TEST(PoseGraph, FindsAnExactSquareFromDisturbedPoses) {
  std::vector<Pose2> truth;
  PoseGraph graph = square(5, truth);
  disturb(graph, 0.5, 3);
  EXPECT_GT(graph.chi2(), 1.0);
  const PoseGraphResult result = graph.optimize();
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.chi2, 1e-12);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_THAT(graph.poses()[i], IsNear(truth[i], 1e-6, 1e-6)) << i;
  }
}

TEST(PoseGraph, TheChiSquareOfAnEdgeIsTheWeightedErrorInItsOwnFrame) {
  PoseGraph graph;
  graph.add_node({0, 0, 0});
  graph.add_node({0, 1, std::numbers::pi / 2});
  PoseGraphEdge edge{0, 1, {0, 0.8, std::numbers::pi / 2}};
  edge.information.diagonal() << 100.0, 1.0, 1.0;
  graph.add_edge(edge);
  // 0.2 m too far along world y, which is x of the measured frame: 100 * 0.2^2.
  EXPECT_NEAR(graph.chi2(), 4.0, 1e-9);
}

TEST(PoseGraph, InitializesFromEdgesAloneHoweverWrongThePosesAre) {
  std::vector<Pose2> truth;
  PoseGraph graph = square(10, truth);
  for (int i = 1; i < 40; ++i) graph.set_pose(i, {5.0, -3.0, 2.0});
  graph.initialize_from_edges();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_THAT(graph.poses()[i], IsNear(truth[i], 1e-6, 1e-6)) << i;
  }
}

TEST(PoseGraph, SwitchesWrongLoopsOffAndKeepsTheRightOne) {
  std::vector<Pose2> truth;
  PoseGraph graph = square(10, truth);
  const Eigen::Matrix3d sure = 1e4 * Eigen::Matrix3d::Identity();
  PoseGraphEdge wrong{3, 27, {0.1, 0.2, 0.3}, sure, true};
  graph.add_edge(wrong);
  graph.add_edge({10, 35, {1.0, -0.2, -2.0}, sure, true});
  disturb(graph, 0.05, 5);
  const PoseGraphResult result = graph.optimize_robustly();
  const std::size_t first_loop = 39;
  EXPECT_TRUE(result.edge_in_force[first_loop]);
  EXPECT_FALSE(result.edge_in_force[first_loop + 1]);
  EXPECT_FALSE(result.edge_in_force[first_loop + 2]);
  EXPECT_THAT(graph.poses()[20], IsNear(truth[20], 1e-6, 1e-6));
}

TEST(PoseGraph, RefusesEdgesThatMakeNoSense) {
  PoseGraph graph;
  graph.add_node({});
  graph.add_node({});
  EXPECT_THROW(graph.add_edge({0, 2, {}}), std::invalid_argument);
  EXPECT_THROW(graph.add_edge({1, 1, {}}), std::invalid_argument);
  EXPECT_THROW(graph.add_edge({0, 1, {std::nan(""), 0, 0}}), std::invalid_argument);
  EXPECT_THROW(graph.add_node({0, std::nan(""), 0}), std::invalid_argument);
}

TEST(PoseGraph, ReachesThePublishedOptimaOfPublicGraphs) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  if (data == nullptr) {
    std::puts("SKIPPED: no MARCO_TEST_DATA");
    GTEST_SKIP();
  }
  struct Case {
    const char* file;
    double optimum;
  };
  for (const Case& graph_case :
       {Case{"INTEL", 215.83}, Case{"MITb", 41.163}, Case{"M3500", 137.913}}) {
    PoseGraph graph = testing::read_g2o(std::string(data) + "/graphs/" + graph_case.file + ".g2o");
    ASSERT_GT(graph.node_count(), 100U);
    graph.initialize_from_edges();
    const PoseGraphResult result = graph.optimize();
    EXPECT_NEAR(result.chi2, graph_case.optimum, 1e-3 * graph_case.optimum) << graph_case.file;
    std::printf("%s: %.3f in %d iterations\n", graph_case.file, result.chi2, result.iterations);
  }
}

}  // namespace
}  // namespace marco::slam
