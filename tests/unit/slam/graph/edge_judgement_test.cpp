#include "slam/back_end/graph/edge_judgement.hpp"

#include <gtest/gtest.h>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// Two ways from node 0 to node 1 that know x to 0.1 and 0.2 m, 0.3 m apart. Turns are known so well
// that the problem is linear.
class EdgeJudgementTest : public ::testing::Test {
 protected:
  EdgeJudgementTest() {
    graph_.add_node({});
    graph_.add_node({1.0, 0.0, 0.0});
    graph_.add_edge({0, 1, {1.0, 0.0, 0.0}, information_of(diagonal_covariance(0.1, 1e-4)), false});
    graph_.add_edge({0, 1, {1.3, 0.0, 0.0}, information_of(diagonal_covariance(0.2, 1e-4)), true});
  }
  PoseGraph graph_;
};

TEST_F(EdgeJudgementTest, AnEdgeIsHeldAgainstWhatAllOthersSay) {
  graph_.optimize();
  const auto judged = judge_edges(graph_, {true, true}, JudgedEdges::all, 16.3);
  // 0.3^2 / (0.1^2 + 0.2^2), for either.
  EXPECT_NEAR(judged[0].squared_distance, 1.8, 1e-6);
  EXPECT_NEAR(judged[1].squared_distance, 1.8, 1e-6);
  // 1 / (1 / 0.1^2 + 1 / 0.2^2); a turn of 1e-4 moves a metre by as much.
  EXPECT_NEAR(judged[0].covariance(0, 0), 0.008, 1e-7);
}

TEST_F(EdgeJudgementTest, AnEdgeOutOfForceIsHeldAgainstTheRest) {
  const auto judged = judge_edges(graph_, {true, false}, JudgedEdges::all, 16.3);
  EXPECT_NEAR(judged[1].squared_distance, 1.8, 1e-6);
  EXPECT_NEAR(judged[1].covariance(0, 0), 0.01, 1e-7);
  EXPECT_NEAR(judged[0].squared_distance, 0.0, 1e-9);  // it alone knows
}

TEST_F(EdgeJudgementTest, OnlyLoopsAreJudgedWhereOnlyTheyAreAsked) {
  const auto judged = judge_edges(graph_, {true, true}, JudgedEdges::loops, 16.3);
  EXPECT_EQ(judged[0].covariance, Eigen::Matrix3d::Zero());
  EXPECT_GT(judged[1].covariance(0, 0), 0.0);
}

}  // namespace
}  // namespace marco::slam
