#include "slam/line_slam/circles/circle_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

constexpr double kRadiusM = 0.075, kSigmaM = 0.01;

struct View {
  std::vector<CircleRay> rays;
  Eigen::Matrix3d fisher = Eigen::Matrix3d::Zero();  // of the ranges that hit
  FittedCircle start;
};

// A sweep of half a degree a beam past a post, and a start that is 2 cm off.
View look_at(const Eigen::Vector2d& post_m, double first_rad, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kSigmaM);
  View view;
  for (int i = 0; i < 60; ++i) {
    const double bearing = first_rad + deg_to_rad(0.5 * (i - 30));
    CircleRay ray;
    ray.origin_m = Eigen::Vector2d::Zero();
    ray.direction = {std::cos(bearing), std::sin(bearing)};
    ray.range_sigma_m = kSigmaM;
    const double along = ray.direction.dot(post_m);
    const Eigen::Vector2d across = post_m - along * ray.direction;
    const double inside = kRadiusM * kRadiusM - across.squaredNorm();
    ray.hit = inside > 0.0;
    if (!ray.hit && across.norm() > kRadiusM + 0.02 * post_m.norm()) continue;
    if (ray.hit) {
      const double half = std::sqrt(inside);
      ray.range_m = along - half + noise(random);
      Eigen::Vector3d jacobian;
      jacobian << ray.direction + across / half, -kRadiusM / half;
      view.fisher += jacobian * jacobian.transpose() / (kSigmaM * kSigmaM);
    }
    view.rays.push_back(ray);
  }
  view.start.centre_m = post_m + Eigen::Vector2d(0.02, -0.01);
  view.start.radius_m = kRadiusM + 0.02;
  return view;
}

TEST(CircleFit, IsAsGoodAsTheRangesAllowAndKnowsHowGood) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> beam(0.0, deg_to_rad(0.5));
  for (const double far_m : {1.0, 2.0, 4.0}) {
    constexpr int kViews = 400;
    Eigen::Array3d squares = Eigen::Array3d::Zero(), bound = squares, claimed = squares;
    int fitted = 0;
    for (int i = 0; i < kViews; ++i) {
      const double at = beam(random);
      const Eigen::Vector2d post_m(far_m * std::cos(at), far_m * std::sin(at));
      const View view = look_at(post_m, beam(random), random);
      const auto circle = fit_circle(view.rays, view.start);
      if (!circle || view.fisher.determinant() < 1e-6) continue;
      ++fitted;
      Eigen::Array3d error;
      error << circle->centre_m - post_m, circle->radius_m - kRadiusM;
      squares += error.square();
      bound += view.fisher.inverse().diagonal().array();
      claimed += circle->covariance.diagonal().array();
    }
    EXPECT_GT(fitted, 0.95 * kViews);
    for (int k = 0; k < 3; ++k) {
      // Cramer and Rao's bound of the ranges alone: rays that pass beside tell more.
      EXPECT_LT(std::sqrt(squares[k] / bound[k]), 1.1) << far_m << " m, value " << k;
      EXPECT_NEAR(std::sqrt(squares[k] / claimed[k]), 0.9, 0.25) << far_m << " m, value " << k;
    }
  }
}

TEST(CircleFit, RoundsTheCircleFromManyPlaces) {
  std::mt19937 random(12);
  std::vector<CircleRay> rays;
  const Eigen::Vector2d post_m(2.0, 0.3);
  View last;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d from_m(0.0, 2.0 * i / 29.0);
    last = look_at(post_m - from_m, std::atan2(post_m.y() - from_m.y(), post_m.x()), random);
    for (CircleRay& ray : last.rays) {
      ray.origin_m = from_m;
      rays.push_back(ray);
    }
  }
  FittedCircle start;
  start.centre_m = post_m + Eigen::Vector2d(0.03, 0.03);
  start.radius_m = 0.12;
  const auto circle = fit_circle(rays, start);
  ASSERT_TRUE(circle);
  EXPECT_LT((circle->centre_m - post_m).norm(), 0.003);
  EXPECT_NEAR(circle->radius_m, kRadiusM, 0.002);
  EXPECT_NEAR(circle->chi2 / circle->hits, 1.0, 0.2);
}

TEST(CircleFit, NeedsThreeHits) {
  std::mt19937 random(13);
  View view = look_at({2.0, 0.0}, 0.0, random);
  view.rays.resize(2);
  EXPECT_FALSE(fit_circle(view.rays, view.start));
}

}  // namespace
}  // namespace marco::slam
