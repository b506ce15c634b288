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

}  // namespace
}  // namespace marco::slam
