#include "landmarks/point_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace marco::slam {
namespace {

constexpr SightingNoise kNoise{0.03, 0.02, 0.02, 0.03};

WheelMotion motion(double way_m, double turn_rad) {
  WheelMotion step;
  step.start_from_end = {way_m, 0.0, turn_rad};
  step.noise = Eigen::Vector3d(1e-4, 1e-5, 4e-4).asDiagonal();
  step.seconds = 1.0;
  step.by_set_up(0, speed_scale) = way_m;
  step.by_set_up(2, turn_scale) = turn_rad;
  step.by_set_up(2, turn_bias) = 1.0;
  return step;
}

PointFilter with_two_posts() {
  PointFilter filter({});
  filter.move(motion(0.5, 0.3));
  filter.add({2.0, 0.4}, kNoise);
  filter.add({3.0, -0.7}, kNoise);
  return filter;
}

TEST(PointFilter, SeesALandmarkWhereItWasPut) {
  PointFilter filter = with_two_posts();
  const PointInnovation seen = filter.innovation({{3.0, -0.7}, 1});
  EXPECT_LT(seen.innovation.norm(), 1e-9);
}

TEST(PointFilter, PolarJacobianIsTheDerivative) {
  const Eigen::Vector2d at(1.2, -0.8);
  const Eigen::Matrix2d jacobian = polar_jacobian(at);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector2d more = at, less = at;
    more[i] += kStep;
    less[i] -= kStep;
    EXPECT_NEAR(jacobian(0, i), (more.norm() - less.norm()) / (2 * kStep), 1e-8);
    EXPECT_NEAR(jacobian(1, i),
                (std::atan2(more.y(), more.x()) - std::atan2(less.y(), less.x())) / (2 * kStep),
                1e-8);
  }
}

TEST(PointFilter, KnowsTheRobotBetterByWhatItSeesAgain) {
  PointFilter filter = with_two_posts();
  filter.move(motion(0.5, 0.2));
  const Eigen::Matrix3d before = filter.robot_covariance();
  filter.correct({{{1.6, 0.1}, 0}, {{2.7, -1.0}, 1}}, kNoise);
  const Eigen::Matrix3d gained = before - filter.robot_covariance();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(gained).eigenvalues().minCoeff(), -1e-9);
  EXPECT_GT(gained.trace(), 1e-5);
}

// Turning the map about the start is not observable: whatever is seen, and however the estimates
// move, the heading never becomes better known than where landmarks were first seen from.
TEST(PointFilter, GainsNoHeadingFromLinearization) {
  SetUpOptions known;
  known.sensor_sigma_m = known.sensor_yaw_sigma_rad = known.speed_scale_sigma = 0.0;
  known.turn_scale_sigma = known.turn_bias_sigma_rad_per_s = 0.0;
  PointFilter filter(known);
  filter.move(motion(0.5, 0.3));
  const double first_variance = filter.robot_covariance()(2, 2);
  filter.add({2.0, 0.4}, kNoise);
  filter.add({3.0, -0.7}, kNoise);
  for (int i = 0; i < 200; ++i) {
    filter.move(motion(0.05, i % 2 == 0 ? 0.3 : -0.3));
    const double off = i % 3 == 0 ? 0.05 : -0.03;  // estimates jump about
    std::vector<SightingOf> seen;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d at = filter.in_sensor(k);
      seen.push_back({{at.norm() + off, std::atan2(at.y(), at.x()) - off}, k});
    }
    filter.correct(seen, kNoise);
    EXPECT_GE(filter.robot_covariance()(2, 2), first_variance * (1.0 - 1e-6));
  }
}

TEST(PointFilter, RemovingALandmarkLeavesTheRest) {
  PointFilter filter = with_two_posts();
  filter.add({1.0, 1.2}, kNoise);
  const Eigen::Vector2d last = filter.landmark(2);
  const Eigen::Matrix2d covariance = filter.landmark_covariance(2);
  const Eigen::Matrix2d between = filter.relative_covariance(1, 2);
  filter.remove(0);
  ASSERT_EQ(filter.size(), 2);
  EXPECT_LT((filter.landmark(0) - last).norm(), 1e-12);
  EXPECT_LT((filter.landmark_covariance(0) - covariance).norm(), 1e-12);
  EXPECT_LT((filter.relative_covariance(1, 0) - between).norm(), 1e-12);
}

TEST(PointFilter, JoinsTwoIntoOneBetterKnown) {
  PointFilter filter = with_two_posts();
  filter.add({2.02, 0.41}, kNoise);
  const Eigen::Vector2d middle = 0.5 * (filter.landmark(0) + filter.landmark(2));
  const double before = filter.relative_covariance(0, 1).trace();
  filter.join(0, 2);
  ASSERT_EQ(filter.size(), 2);
  EXPECT_LT((filter.landmark(0) - middle).norm(), 0.01);
  EXPECT_LT(filter.relative_covariance(0, 1).trace(), before);
}

}  // namespace
}  // namespace marco::slam
