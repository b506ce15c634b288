#include "slam/front_end/prediction_record.hpp"

#include <gtest/gtest.h>

namespace marco::slam {
namespace {

TEST(PredictionError, FollowsTheMeanOfTheLastTwentyScans) {
  PredictionError error;
  for (int i = 0; i < 200; ++i) error.update({0.3, 0.4, 0.1});
  EXPECT_NEAR(error.m2, 0.25, 1e-4);
  EXPECT_NEAR(error.rad2, 0.01, 1e-6);
  for (int i = 0; i < 60; ++i) error.update({0.0, 0.0, 0.0});
  EXPECT_LT(error.m2, 0.1 * 0.25);
}

TEST(ExplainedMotion, BelievesUntilSomethingHasMoved) {
  ExplainedMotion explained;
  for (int i = 0; i < 50; ++i) explained.update({0.005, 0, 0.002}, {});
  EXPECT_TRUE(explained.explains_translation());
  EXPECT_TRUE(explained.explains_rotation());
}

TEST(ExplainedMotion, DoubtsTheHalfThatIsWrong) {
  ExplainedMotion explained;
  for (int i = 0; i < 5; ++i) explained.update({0.3, 0, 0.3}, {0.28, 0, -0.3});
  EXPECT_TRUE(explained.explains_translation());
  EXPECT_FALSE(explained.explains_rotation());
  // It comes right again, after some turning.
  for (int i = 0; i < 60; ++i) explained.update({0.3, 0, 0.3}, {0.28, 0, 0.3});
  EXPECT_TRUE(explained.explains_rotation());
}

TEST(ExplainedMotion, DoubtsWhatNeverChangesAfterThirtyCentimetres) {
  ExplainedMotion explained;
  explained.update({0.3, 0, 0.0}, {});
  EXPECT_FALSE(explained.explains_translation());
  EXPECT_TRUE(explained.explains_rotation()) << "it has not turned";
}

TEST(ExplainedMotion, OneWrongMatchCondemnsNoGoodOdometry) {
  ExplainedMotion explained;
  for (int i = 0; i < 10; ++i) explained.update({0.5, 0, 0.1}, {0.5, 0, 0.1});
  explained.update({1.2, 0, 0.1}, {0.2, 0, 0.1});
  EXPECT_TRUE(explained.explains_translation());
}

}  // namespace
}  // namespace marco::slam
