#include "slam/front_end/prediction_record.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace marco::slam {
namespace {

constexpr double kAssumedPerM = 0.15, kSureM = 0.01;

TEST(PredictionError, FollowsTheMeanOfTheLastTwentyScans) {
  PredictionError error;
  for (int i = 0; i < 200; ++i) error.update({0.3, 0.4, 0.1}, true);
  EXPECT_NEAR(error.m2, 0.25, 1e-4);
  EXPECT_NEAR(error.rad2, 0.01, 1e-6);
  for (int i = 0; i < 60; ++i) error.update({0.0, 0.0, 0.0}, true);
  EXPECT_LT(error.m2, 0.1 * 0.25);
}

TEST(ExplainedMotion, BelievesUntilSomethingHasMoved) {
  ExplainedMotion explained;
  for (int i = 0; i < 50; ++i) explained.update({0.005, 0, 0.002}, {}, kSureM);
  EXPECT_TRUE(explained.explains_translation());
  EXPECT_TRUE(explained.explains_rotation());
}

TEST(ExplainedMotion, DoubtsTheHalfThatIsWrong) {
  ExplainedMotion explained;
  for (int i = 0; i < 5; ++i) explained.update({0.3, 0, 0.3}, {0.28, 0, -0.3}, kSureM);
  EXPECT_TRUE(explained.explains_translation());
  EXPECT_FALSE(explained.explains_rotation());
  // It comes right again, after some turning.
  for (int i = 0; i < 60; ++i) explained.update({0.3, 0, 0.3}, {0.28, 0, 0.3}, kSureM);
  EXPECT_TRUE(explained.explains_rotation());
}

TEST(ExplainedMotion, DoubtsWhatNeverChangesAfterThirtyCentimetres) {
  ExplainedMotion explained;
  explained.update({0.3, 0, 0.0}, {}, kSureM);
  EXPECT_FALSE(explained.explains_translation());
  EXPECT_TRUE(explained.explains_rotation()) << "it has not turned";
}

TEST(ExplainedMotion, OneWrongMatchCondemnsNoGoodOdometry) {
  ExplainedMotion explained;
  for (int i = 0; i < 10; ++i) explained.update({0.5, 0, 0.1}, {0.5, 0, 0.1}, kSureM);
  explained.update({1.2, 0, 0.1}, {0.2, 0, 0.1}, kSureM);
  EXPECT_TRUE(explained.explains_translation());
}

TEST(ExplainedMotion, OneJumpDoesNotEndTrust) {
  ExplainedMotion explained;
  for (int i = 0; i < 10; ++i) explained.update({1.0, 0, 0.3}, {1.0, 0, 0.3}, kSureM);
  explained.update({1.0, 0, 0.0}, {2.5, -1.4, -1.5}, kSureM);
  EXPECT_TRUE(explained.explains_translation());
  EXPECT_TRUE(explained.explains_rotation());
  // A wrong sign still does, within a few metres and turns.
  for (int i = 0; i < 5; ++i) explained.update({1.0, 0, 1.0}, {-1.0, 0, -1.0}, kSureM);
  EXPECT_FALSE(explained.explains_translation());
  EXPECT_FALSE(explained.explains_rotation());
}

double learned_per_m(double error_m, int steps, double sigma_m = kSureM) {
  OdometryNoise noise;
  for (int i = 0; i < steps; ++i) {
    noise.update({1.0, 0, 0}, {1.0 + (i % 2 == 0 ? error_m : -error_m), 0, 0}, sigma_m,
                 kAssumedPerM);
  }
  return noise.sigma_per_m(kAssumedPerM);
}

// Of an error along the way half is taken for one axis.
TEST(OdometryNoise, IsLearnedFromWhatScansSay) {
  EXPECT_DOUBLE_EQ(learned_per_m(0.08, 0), kAssumedPerM);
  EXPECT_NEAR(learned_per_m(0.08, 1000), 0.08 * std::sqrt(0.5), 0.01);
  EXPECT_DOUBLE_EQ(learned_per_m(1.0, 1000), kAssumedPerM) << "never more than assumed";
  EXPECT_NEAR(learned_per_m(0.0, 1000), 0.03, 0.005) << "what was assumed still counts";
}

TEST(OdometryNoise, LearnsNothingFromMatchesThatKnowNoBetter) {
  EXPECT_DOUBLE_EQ(learned_per_m(0.0, 1000, 0.05), kAssumedPerM);
}

// What is learned of a step does not depend on how long it is.
TEST(OdometryNoise, IsLearnedOfASlowRobotToo) {
  OdometryNoise slow;
  for (int i = 0; i < 100; ++i) slow.update({0.2, 0, 0}, {0.2, 0, 0}, 0.002, kAssumedPerM);
  EXPECT_LT(slow.ahead_per_m(kAssumedPerM), 0.06);
}

TEST(OdometryNoise, ForgetsAfterSomeHundredMetres) {
  OdometryNoise noise;
  for (int i = 0; i < 300; ++i) noise.update({1, 0, 0}, {1.2, 0, 0}, kSureM, kAssumedPerM);
  for (int i = 0; i < 1500; ++i) noise.update({1, 0, 0}, {1, 0, 0}, kSureM, kAssumedPerM);
  EXPECT_LT(noise.sigma_per_m(kAssumedPerM), 0.04);
}

}  // namespace
}  // namespace marco::slam
