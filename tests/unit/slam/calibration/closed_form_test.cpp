#include "slam/calibration/closed_form.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// An arc in closed form, by its centre: another way than ArcMotion's.
Pose2 arc(double ahead_m, double turn_rad) {
  if (turn_rad == 0.0) return {ahead_m, 0.0, 0.0};
  const double radius_m = ahead_m / turn_rad;
  return {radius_m * std::sin(turn_rad), radius_m * (1.0 - std::cos(turn_rad)), turn_rad};
}

const RobotModel kTruth{0.021, 0.0205, 0.09, {0.03, -0.02, -1.5}};

MotionSample sample_of(double left_rad, double right_rad) {
  const double left_m = kTruth.left_scale * left_rad, right_m = kTruth.right_scale * right_rad;
  const Pose2 moved = arc(0.5 * (left_m + right_m), (right_m - left_m) / kTruth.track_m);
  const Pose2& laser = kTruth.robot_from_laser;
  return {{{left_rad, right_rad, 0.0}}, laser.inverse() * moved * laser, {}};
}

std::vector<MotionSample> any_samples(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> wheel(-1.0, 1.0);
  std::vector<MotionSample> samples;
  for (int i = 0; i < count; ++i) samples.push_back(sample_of(wheel(random), wheel(random)));
  return samples;
}

TEST(ClosedForm, FindsTheRobotExactly) {
  const auto found = calibrate_in_closed_form(any_samples(50));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->model.left_scale, kTruth.left_scale, 1e-9);
  EXPECT_NEAR(found->model.right_scale, kTruth.right_scale, 1e-9);
  EXPECT_NEAR(found->model.track_m, kTruth.track_m, 1e-9);
  EXPECT_THAT(found->model.robot_from_laser, IsNear(kTruth.robot_from_laser, 1e-8, 1e-7));
}

// The sum of squares that it minimizes, at the minimum and beside it.
TEST(ClosedForm, IsTheLeastSquaresOfPositions) {
  std::vector<MotionSample> samples = any_samples(200);
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, 0.001);
  for (MotionSample& sample : samples) {
    sample.laser_moved.x_m += noise(random);
    sample.laser_moved.y_m += noise(random);
  }
  const auto found = calibrate_in_closed_form(samples);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(found->kept.size(), samples.size());
  const auto cost = [&](const RobotModel& model) {
    double sum = 0.0;
    for (const MotionSample& sample : found->kept) {
      sum += error_of(sample, model).head<2>().squaredNorm();
    }
    return sum;
  };
  const double least = cost(found->model);
  for (const double step : {-1e-3, 1e-3}) {
    RobotModel beside = found->model;
    beside.robot_from_laser.x_m += step;
    EXPECT_GT(cost(beside), least);
    beside = found->model;
    beside.robot_from_laser.y_m += step;
    EXPECT_GT(cost(beside), least);
    beside = found->model;
    beside.robot_from_laser.theta_rad += 10 * step;
    EXPECT_GT(cost(beside), least);
    // Track and scales in their ratio: the angles stay.
    beside = found->model;
    beside.track_m *= 1.0 + 10 * step;
    beside.left_scale *= 1.0 + 10 * step;
    beside.right_scale *= 1.0 + 10 * step;
    EXPECT_GT(cost(beside), least);
  }
}

TEST(ClosedForm, DropsWhatIsWildlyWrong) {
  std::vector<MotionSample> samples = any_samples(1000);
  for (std::size_t i = 0; i < 20; ++i) samples[50 * i].laser_moved.x_m += 0.3;
  const auto found = calibrate_in_closed_form(samples);
  ASSERT_TRUE(found.has_value());
  EXPECT_THAT(found->model.robot_from_laser, IsNear(kTruth.robot_from_laser, 1e-6, 1e-6));
}

TEST(ClosedForm, RefusesOneKindOfMotion) {
  std::vector<MotionSample> straight, spin, one_arc;
  for (int i = 1; i <= 50; ++i) {
    const double way = 0.02 * i;
    straight.push_back(sample_of(way, way * kTruth.left_scale / kTruth.right_scale));
    spin.push_back(sample_of(-way, way));
    one_arc.push_back(sample_of(way, 0.5 * way));
  }
  EXPECT_FALSE(calibrate_in_closed_form(straight).has_value());
  EXPECT_FALSE(calibrate_in_closed_form(spin).has_value());
  EXPECT_FALSE(calibrate_in_closed_form(one_arc).has_value());
  EXPECT_FALSE(calibrate_in_closed_form({}).has_value());
}

}  // namespace
}  // namespace marco::slam
