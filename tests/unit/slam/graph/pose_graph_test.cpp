#include "slam/back_end/graph/pose_graph.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/support/g2o_graph.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/real_data.hpp"

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
  testing::initialize_from_edges(graph);
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
  EXPECT_TRUE(result.edge_is_inlier[first_loop]);
  EXPECT_FALSE(result.edge_is_inlier[first_loop + 1]);
  EXPECT_FALSE(result.edge_is_inlier[first_loop + 2]);
  EXPECT_THAT(graph.poses()[20], IsNear(truth[20], 1e-6, 1e-6));
}

// Straight on for `nodes` steps of 1 m, each known to 2 cm and 0.6 deg, measured without error.
PoseGraph chain(int nodes) {
  PoseGraph graph;
  for (int i = 0; i < nodes; ++i) graph.add_node({static_cast<double>(i), 0.0, 0.0});
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.diagonal() << 2500.0, 2500.0, 1e4;
  for (int i = 0; i + 1 < nodes; ++i) graph.add_edge({i, i + 1, {1.0, 0.0, 0.0}, information});
  return graph;
}

TEST(PoseGraph, AWrongLoopThatTheWayGivesInToIsOut) {
  PoseGraph graph = chain(51);
  Eigen::Matrix3d sure = Eigen::Matrix3d::Zero();
  sure.diagonal() << 400.0, 400.0, 1e4;
  graph.add_edge({0, 50, {51.0, 0.0, 0.0}, sure, true});
  // 1 m off along the way, whose variance is 50 * 0.02^2 m2, the loop's 0.05^2: 44 variances. The
  // way gives in by 0.89 m, and what is left, 0.11 m, the loop alone could be off by.
  PoseGraph bent = graph;
  EXPECT_LT(bent.optimize().chi2, 45.0);
  EXPECT_LT(bent.edge_chi2(graph.edges().back()), 16.3);
  const PoseGraphResult result = graph.optimize_robustly();
  EXPECT_FALSE(result.edge_is_inlier.back());
  EXPECT_THAT(graph.poses()[50], IsNear(Pose2{50.0, 0.0, 0.0}, 1e-6, 1e-6));
}

TEST(PoseGraph, AWayThatMustTurnArrivesInAFewSteps) {
  // A loop says that the end lies 30 m aside: the chain bends by a radian, in steps that are no
  // longer linear. Without solving the translations anew it takes more than 100.
  PoseGraph graph = chain(200);
  graph.add_edge({0, 199, {150.0, 120.0, 1.0}, 1e4 * Eigen::Matrix3d::Identity(), true});
  const PoseGraphResult result = graph.optimize();
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.iterations, 20);
}

TEST(PoseGraph, RefusesEdgesThatMakeNoSense) {
  PoseGraph graph;
  graph.add_node({});
  graph.add_node({});
  EXPECT_THROW(graph.add_edge({0, 2, {}}), std::invalid_argument);
  EXPECT_THROW(graph.add_edge({1, 1, {}}), std::invalid_argument);
  EXPECT_THROW(graph.add_edge({0, 1, {std::nan(""), 0, 0}}), std::invalid_argument);
  EXPECT_THROW(graph.add_node({0, std::nan(""), 0}), std::invalid_argument);
  const Eigen::Matrix3d indefinite = Eigen::Vector3d(100.0, 100.0, -1.0).asDiagonal();
  EXPECT_THROW(graph.add_edge({0, 1, {}, indefinite}), std::invalid_argument);
}

// Along a bare corridor a match knows where the walls are and nothing of the way along: its
// information is singular. Such a loop counts across the corridor, where a wrong one is found out,
// and moves nothing along it.
TEST(PoseGraph, ALoopThatKnowsOneDirectionOnlyIsJudgedAndBelievedInThatOne) {
  const Eigen::Matrix3d across = Eigen::Vector3d(0.0, 1e4, 0.0).asDiagonal();
  for (const double aside_m : {0.0, 15.0}) {
    PoseGraph graph = chain(60);
    graph.add_edge({10, 50, {70.0, aside_m, 0.0}, across, true});
    const PoseGraphResult result = graph.optimize_robustly();
    EXPECT_EQ(result.edge_is_inlier.back(), aside_m == 0.0) << aside_m;
    for (int i = 0; i < 60; ++i) {
      EXPECT_THAT(graph.poses()[static_cast<std::size_t>(i)],
                  IsNear(Pose2{1.0 * i, 0, 0}, 1e-6, 1e-6))
          << aside_m;
    }
  }
}

TEST(PoseGraph, ReachesThePublishedOptimaOfPublicGraphs) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) GTEST_SKIP();
  struct Case {
    const char* file;
    double optimum;
  };
  for (const Case& graph_case :
       {Case{"INTEL", 215.83}, Case{"MITb", 41.163}, Case{"M3500", 137.913}}) {
    PoseGraph graph = testing::read_g2o(std::string(data) + "/graphs/" + graph_case.file + ".g2o");
    ASSERT_GT(graph.node_count(), 100U);
    testing::initialize_from_edges(graph);
    const PoseGraphResult result = graph.optimize();
    EXPECT_NEAR(result.chi2, graph_case.optimum, 1e-3 * graph_case.optimum) << graph_case.file;
    std::printf("%s: %.3f in %d iterations\n", graph_case.file, result.chi2, result.iterations);
  }
}

TEST(PoseGraph, FindsTheLoopsOfAPublicGraphWhoseOdometryIsNoStart) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) GTEST_SKIP();
  // 20 loops and 10 wrong ones; odometry ends 200 m off.
  PoseGraph graph = testing::read_g2o(std::string(data) + "/graphs/MITb.g2o");
  PoseGraph optimum = graph;
  testing::initialize_from_edges(optimum);
  optimum.optimize();
  const std::size_t right = graph.edges().size();
  std::mt19937 random(1);
  testing::add_wrong_loops(graph, 10, random);
  testing::place_along_odometry(graph);
  const PoseGraphResult result = graph.optimize_robustly();
  for (std::size_t i = 0; i < graph.edges().size(); ++i) {
    EXPECT_EQ(result.edge_is_inlier[i], i < right) << i;
  }
  for (std::size_t i = 0; i < graph.node_count(); ++i) {
    EXPECT_THAT(graph.poses()[i], IsNear(optimum.poses()[i], 0.1, 0.01)) << i;
  }
}

}  // namespace
}  // namespace marco::slam
