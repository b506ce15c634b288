#include "slam/front_end/odometry_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace marco::slam {
namespace {

// After corrections that scans know exactly, of this size each half a metre.
OdometryNoise after(int corrections, const Eigen::Vector3d& size) {
  OdometryNoise noise;
  for (int i = 0; i < corrections; ++i) {
    noise.learn_drift({i % 2 == 0 ? size : Eigen::Vector3d(-size), Eigen::Matrix3d::Zero()}, 0.5,
                      true);
  }
  return noise;
}

TEST(OdometryNoise, DriftIsLearnedFromWhatScansCorrect) {
  const OdometryNoise noise = after(200, {0.03, 0.01, 0.02});
  EXPECT_NEAR(noise.drift_per_m.x(), 0.03 * 0.03 / 0.5, 1e-5);
  EXPECT_NEAR(noise.drift_per_m.y(), 0.01 * 0.01 / 0.5, 1e-6);
  EXPECT_NEAR(noise.drift_per_m.z(), 0.02 * 0.02 / 0.5, 1e-5);
}

TEST(OdometryNoise, DriftOfAWayGrowsWithItsLengthAndItsTurn) {
  const OdometryNoise noise;
  const double metre = noise.drift({1.0, 0, 0})(0, 0);
  EXPECT_NEAR(noise.drift({0.6, 0.8, 0})(1, 1), metre, 1e-12);
  EXPECT_NEAR(noise.drift({2.0, 0, 0})(0, 0), 2.0 * metre, 1e-12);
  EXPECT_NEAR(noise.drift({0, 0, -2.0})(0, 0), metre, 1e-12) << "a turn by two radians is a metre";
}

TEST(OdometryNoise, ScansThatKnowNothingTeachNothing) {
  OdometryNoise noise;
  const OdometryNoise assumed = noise;
  for (int i = 0; i < 100; ++i) {
    // Where a scan leaves all open, what is left is what was assumed.
    noise.learn_drift({Eigen::Vector3d::Zero(), assumed.drift({0.5, 0, 0})}, 0.5, true);
    noise.learn_jitter({Eigen::Vector3d::Zero(), assumed.jitter()}, true);
  }
  EXPECT_TRUE(noise.drift_per_m.isApprox(assumed.drift_per_m, 1e-9));
  EXPECT_NEAR(noise.jitter_m2, assumed.jitter_m2, 1e-12);
  EXPECT_NEAR(noise.jitter_rad2, assumed.jitter_rad2, 1e-12);
}

TEST(OdometryNoise, WheelsThatProveExactAreBelievedMoreAndMore) {
  const OdometryNoise assumed, proved = after(60, Eigen::Vector3d::Zero());
  EXPECT_LT(proved.drift_per_m.x(), 0.1 * assumed.drift_per_m.x());
  EXPECT_GT(proved.drift_per_m.x(), 0.0) << "but never for exact";
  EXPECT_EQ(after(1000, Eigen::Vector3d::Zero()).drift_per_m.x(), proved.drift_per_m.x());
}

TEST(OdometryNoise, OneSlipDecidesNothingAndIsForgotten) {
  OdometryNoise noise = after(100, {0.005, 0.005, 0.005});
  const double usual = noise.drift_per_m.x();
  noise.learn_drift({{1.0, 0, 0}, Eigen::Matrix3d::Zero()}, 0.5, true);
  EXPECT_LT(noise.drift_per_m.x(), 1.5 * usual);
  for (int i = 0; i < 100; ++i) {
    noise.learn_drift({{0.005, 0, 0}, Eigen::Matrix3d::Zero()}, 0.5, true);
  }
  EXPECT_NEAR(noise.drift_per_m.x(), usual, 0.02 * usual);
}

TEST(OdometryNoise, WheelsThatGoBadAreDoubtedWithinSomeMetres) {
  OdometryNoise noise = after(100, Eigen::Vector3d::Zero());
  int corrections = 0;
  while (noise.drift_per_m.x() < 0.1 * 0.1 && ++corrections < 100) {
    noise.learn_drift({{0.2, 0, 0}, Eigen::Matrix3d::Zero()}, 0.5, true);
  }
  EXPECT_LE(corrections, 25) << "keyframes";
}

TEST(OdometryNoise, JitterIsTheMeanOfBothAxesAndOfTheTurn) {
  OdometryNoise noise;
  for (int i = 0; i < 400; ++i) {
    noise.learn_jitter({{0.02, 0, 0.01}, Eigen::Matrix3d::Zero()}, true);
  }
  EXPECT_NEAR(std::sqrt(noise.jitter()(1, 1)), 0.02 * std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(std::sqrt(noise.jitter()(2, 2)), 0.01, 1e-4);
}

TEST(OdometryNoise, TheHeadingOfAGyroscopeDoesNotJudgeTheWheels) {
  OdometryNoise noise;
  const OdometryNoise assumed = noise;
  noise.learn_drift({{0.1, 0, 0.5}, Eigen::Matrix3d::Zero()}, 0.5, false);
  noise.learn_jitter({{0.1, 0, 0.5}, Eigen::Matrix3d::Zero()}, false);
  EXPECT_EQ(noise.drift_per_m.z(), assumed.drift_per_m.z());
  EXPECT_EQ(noise.jitter_rad2, assumed.jitter_rad2);
  EXPECT_GT(noise.drift_per_m.x(), assumed.drift_per_m.x());
  EXPECT_GT(noise.jitter_m2, assumed.jitter_m2);
}

TEST(OdometryNoise, AWayTooShortToJudgeIsLeftOut) {
  OdometryNoise noise;
  noise.learn_drift({{0.02, 0.02, 0.02}, Eigen::Matrix3d::Zero()}, 0.01, true);
  EXPECT_EQ(noise.drift_per_m.x(), OdometryNoise().drift_per_m.x());
}

TEST(OdometryBias, AGyroscopesTurnIsLeftAlone) {
  OdometryBias bias;
  bias.add({0.1, 0.2, 0.3});
  EXPECT_THAT(bias.corrected({1.0, 0, 0.5}, true), IsNear(Pose2{1.1, 0, 0.5}, 1e-9, 1e-9));
  EXPECT_THAT(bias.corrected({1.0, 0, 0.5}, false), IsNear(Pose2{1.1, 0, 0.9}, 1e-9, 1e-9));
  EXPECT_EQ(OdometryBias::derivative({1.0, 0, 0.5}, 0.0, true).rightCols<2>().norm(), 0.0);
}

TEST(OdometryBias, DerivativeIsThatOfTheCorrectedStep) {
  const Pose2 before{2.0, -1.0, 0.7}, step{0.3, 0.05, 0.2};
  const Eigen::Matrix3d by = OdometryBias::derivative(step, before.theta_rad, false);
  for (int part = 0; part < 3; ++part) {
    OdometryBias bias;
    constexpr double kSmall = 1e-6;
    bias.add(kSmall * Eigen::Vector3d::Unit(part));
    const Eigen::Vector3d moved =
        difference(before * bias.corrected(step, false), before * step) / kSmall;
    EXPECT_LT((moved - by.col(part)).norm(), 1e-5) << part;
  }
}

}  // namespace
}  // namespace marco::slam
