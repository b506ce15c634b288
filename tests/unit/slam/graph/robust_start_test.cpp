#include "slam/back_end/graph/robust_start.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// Two laps of a square of 10 m a side, 1 m a step; odometry turns by 2 % too much.
struct TwoLaps {
  static constexpr int kLap = 40;
  std::vector<Pose2> truth;
  std::vector<PoseGraphEdge> edges;

  TwoLaps() {
    Pose2 pose;
    for (int i = 0; i < 2 * kLap; ++i) {
      truth.push_back(pose);
      pose = pose * Pose2{1.0, 0.0, i % 10 == 9 ? std::numbers::pi / 2 : 0.0};
    }
    const Eigen::Matrix3d information = diagonal_covariance(0.05, 0.05).inverse();
    for (int i = 0; i + 1 < 2 * kLap; ++i) {
      Pose2 step = between(at(i), at(i + 1));
      step.theta_rad *= 1.02;
      edges.push_back({i, i + 1, step, information, false});
    }
    for (int i = 0; i < kLap; i += 2) add_loop(i, i + kLap, between(at(i), at(i + kLap)));
  }
  const Pose2& at(int node) const { return truth[static_cast<std::size_t>(node)]; }
  void add_loop(int from, int to, const Pose2& measured) {
    edges.push_back({from, to, measured, diagonal_covariance(0.02, 0.01).inverse(), true});
  }
  double worst_error_m(const RobustStart& start) const {
    double worst_m = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      worst_m =
          std::max(worst_m, (start.poses[i].translation_m() - truth[i].translation_m()).norm());
    }
    return worst_m;
  }
};

TEST(RobustStart, LoopsThatAgreeAreAllInliersAndGiveThePoses) {
  const TwoLaps laps;
  const RobustStart start =
      robust_start(laps.truth.front(), laps.truth.size(), laps.edges, kChi2Dof3Quantile999);
  ASSERT_EQ(start.weights.size(), laps.edges.size());
  for (const double weight : start.weights) EXPECT_EQ(weight, 1.0);
  EXPECT_EQ(start.poses.front().vector(), laps.truth.front().vector());
  // Odometry alone is off by metres; nothing is known of the laps' common bend but by odometry.
  EXPECT_LT(laps.worst_error_m(start), 1.0);
}

TEST(RobustStart, RandomLoopsAreOutliersHoweverManyAndMoveNothing) {
  const TwoLaps right;
  TwoLaps laps;
  const std::size_t first_wrong = laps.edges.size();
  std::mt19937 random(7);
  std::uniform_int_distribution<int> node(0, 2 * TwoLaps::kLap - 1);
  std::uniform_real_distribution<double> at(-3.0, 3.0);
  while (laps.edges.size() < first_wrong + 15) {
    const int from = node(random), to = node(random);
    const Pose2 measured{at(random), at(random), at(random)};
    if (std::abs(to - from) < 5) continue;
    if ((between(laps.at(from), laps.at(to)).translation_m() - measured.translation_m()).norm() <
        2) {
      continue;
    }
    laps.add_loop(from, to, measured);
  }
  const RobustStart start =
      robust_start(laps.truth.front(), laps.truth.size(), laps.edges, kChi2Dof3Quantile999);
  for (std::size_t i = 0; i < laps.edges.size(); ++i) {
    EXPECT_EQ(start.weights[i], i < first_wrong ? 1.0 : 0.0) << i;
  }
  const RobustStart without =
      robust_start(right.truth.front(), right.truth.size(), right.edges, kChi2Dof3Quantile999);
  EXPECT_LT(laps.worst_error_m(start), laps.worst_error_m(without) + 0.05);
}

}  // namespace
}  // namespace marco::slam
