#include "slam/back_end/graph/relative_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

constexpr double kFarM2 = 1e6;

PoseGraphEdge edge_between(const std::vector<Pose2>& poses,
                           int from,
                           int to,
                           const Eigen::Matrix3d& covariance) {
  PoseGraphEdge edge;
  edge.from = from;
  edge.to = to;
  edge.from_from_to =
      between(poses[static_cast<std::size_t>(from)], poses[static_cast<std::size_t>(to)]);
  edge.information = information_of(covariance);
  return edge;
}

std::vector<Pose2> line_of_nodes(int count) {
  std::vector<Pose2> poses;
  for (int i = 0; i < count; ++i) poses.push_back({1.0 * i, 0.0, 0.0});
  return poses;
}

// The oracle: the poses are drawn, and what is seen is compared.
TEST(RelativeUncertainty, OfAChainIsWhatSamplesShow) {
  const std::vector<Pose2> poses = {
      {0, 0, 0.2}, {1, 0.5, 0.9}, {1.2, 2, 1.8}, {0, 2.5, -2.9}, {-1, 2, -2.0}};
  const Eigen::Vector3d sigmas(0.02, 0.01, 0.03);
  const Eigen::Matrix3d noise = sigmas.cwiseAbs2().asDiagonal();
  std::vector<PoseGraphEdge> edges;
  // One edge is given the other way round.
  for (int i = 0; i < 4; ++i) {
    edges.push_back(i == 2 ? edge_between(poses, i + 1, i, noise)
                           : edge_between(poses, i, i + 1, noise));
  }
  const RelativeUncertainty known = relative_uncertainties(4, poses, edges, kFarM2).front();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  constexpr int kSamples = 40000;
  const Pose2 expected = between(poses[0], poses[4]);
  for (int sample = 0; sample < kSamples; ++sample) {
    Pose2 seen;
    for (const PoseGraphEdge& edge : edges) {
      const Pose2 error{sigmas.x() * normal(random), sigmas.y() * normal(random),
                        sigmas.z() * normal(random)};
      const Pose2 measured = edge.from_from_to * error;
      seen = edge.from < edge.to ? seen * measured : seen * measured.inverse();
    }
    const Eigen::Vector3d off = (expected.inverse() * seen).vector();
    sum += off * off.transpose();
  }
  const Eigen::Matrix3d drawn = sum / kSamples;
  EXPECT_LT((drawn - known.covariance).norm(), 0.03 * drawn.norm());
  double way_m = 0.0;
  for (const PoseGraphEdge& edge : edges) way_m += edge.from_from_to.translation_m().norm();
  EXPECT_NEAR(known.way_m, way_m, 1e-12);
}

TEST(RelativeUncertainty, ALoopIsAShortCut) {
  const std::vector<Pose2> poses = line_of_nodes(10);
  const Eigen::Matrix3d noise = diagonal_covariance(0.1, 1e-3);
  std::vector<PoseGraphEdge> edges;
  for (int i = 0; i < 9; ++i) edges.push_back(edge_between(poses, i, i + 1, noise));
  EXPECT_NEAR(relative_uncertainties(9, poses, edges, kFarM2)[0].covariance(0, 0), 0.09, 1e-3);
  edges.push_back(edge_between(poses, 1, 9, noise));
  const auto known = relative_uncertainties(9, poses, edges, kFarM2);
  EXPECT_NEAR(known[0].covariance(0, 0), 0.02, 1e-3);
  EXPECT_NEAR(known[4].covariance(0, 0), 0.04, 1e-3);
  EXPECT_NEAR(known[6].covariance(0, 0), 0.03, 1e-3);
  // A loop that knows nothing of the way along is none.
  edges.back().information(0, 0) = 0.0;
  EXPECT_NEAR(relative_uncertainties(9, poses, edges, kFarM2)[0].covariance(0, 0), 0.09, 1e-3);
}

TEST(RelativeUncertainty, BeyondTheLimitIsTheLimit) {
  const std::vector<Pose2> poses = line_of_nodes(11);
  std::vector<PoseGraphEdge> edges;
  for (int i = 0; i < 9; ++i) {
    edges.push_back(edge_between(poses, i, i + 1, diagonal_covariance(0.1, 1e-3)));
  }
  const auto known = relative_uncertainties(9, poses, edges, 0.1);
  EXPECT_NEAR(known[5].covariance(0, 0), 0.04, 1e-3);
  for (const std::size_t node : {0U, 2U, 10U}) {
    EXPECT_NEAR(known[node].covariance(0, 0), 0.05, 1e-12);
    EXPECT_NEAR(known[node].covariance(2, 2), std::numbers::pi * std::numbers::pi, 1e-12);
  }
  EXPECT_EQ(known[9].covariance.norm(), 0.0);
  EXPECT_THROW(relative_uncertainties(0, line_of_nodes(9), edges, 1.0), std::out_of_range);
}

}  // namespace
}  // namespace marco::slam
