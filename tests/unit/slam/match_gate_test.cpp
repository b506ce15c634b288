#include "slam/front_end/match_gate.hpp"

#include <gtest/gtest.h>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

class MatchGateTest : public ::testing::Test {
 protected:
  MatchGateTest() { motion_.update({Utime::from_us(0), Pose2{}, {}}, {}); }
  bool refuses(double jump_m, int64_t ms, bool usable = true) {
    const ScanMatch match{{jump_m, 0, 0}, Eigen::Matrix3d::Identity(), 0.9, usable};
    return gate_.refuses(match, Pose2{}, motion_, Utime::from_us(1000 * ms));
  }
  MotionModel motion_;
  MatchGate gate_;
};

TEST_F(MatchGateTest, AMatchWithinWhatARobotCanDriveIsAccepted) {
  // 3 m/s for 0.1 s and 0.3 m.
  EXPECT_FALSE(refuses(0.55, 100));
  EXPECT_FALSE(gate_.state().jumps_since.has_value());
  EXPECT_TRUE(refuses(0.65, 100));
  EXPECT_EQ(gate_.state().jumps_since.value().us, 100'000);
}

TEST_F(MatchGateTest, JumpsAreBelievedWhenAllMatchesJumpForASecond) {
  EXPECT_TRUE(refuses(5.0, 100));
  EXPECT_TRUE(refuses(5.0, 1000));
  EXPECT_FALSE(refuses(5.0, 1100));
  // From then on the second counts again.
  EXPECT_TRUE(refuses(5.0, 1200));
}

TEST_F(MatchGateTest, AMatchBetweenThatFitsEndsTheSecond) {
  EXPECT_TRUE(refuses(5.0, 100));
  EXPECT_FALSE(refuses(0.0, 600));
  EXPECT_TRUE(refuses(5.0, 1200));
}

TEST_F(MatchGateTest, AMatchThatIsNotUsableIsNoJump) {
  EXPECT_FALSE(refuses(5.0, 100, false));
  EXPECT_FALSE(gate_.state().jumps_since.has_value());
}

TEST_F(MatchGateTest, AScanThatFitsNothingIsDrawnOnlyAsTheThirdInARow) {
  EXPECT_TRUE(gate_.may_draw());
  gate_.note_match(false);
  EXPECT_FALSE(gate_.may_draw());
  gate_.note_match(false);
  EXPECT_FALSE(gate_.may_draw());
  gate_.note_match(false);
  EXPECT_TRUE(gate_.may_draw());
  gate_.note_match(true);
  gate_.note_match(false);
  EXPECT_FALSE(gate_.may_draw());
}

// Oracle: Monte Carlo over small errors of both poses.
TEST(Covariance, AHeadingErrorMovesWhatLiesAheadSideways) {
  const Eigen::Matrix3d start = diagonal_covariance(0.01, 0.02);
  const Eigen::Matrix3d ahead = carried_along(start, {1, 2, 0.5}, {1, 12, 0.7});
  // 10 m along y: the heading's error moves it along x.
  EXPECT_NEAR(std::sqrt(ahead(0, 0)), std::hypot(0.01, 10 * 0.02), 1e-12);
  EXPECT_NEAR(std::sqrt(ahead(1, 1)), 0.01, 1e-12);
  EXPECT_NEAR(ahead(0, 2), -10 * 0.02 * 0.02, 1e-12);
}

TEST(Covariance, RotatedAndInvertedMatricesAreThoseOfTheTurnedFrame) {
  Eigen::Matrix3d covariance = Eigen::Vector3d(4.0, 1.0, 0.25).asDiagonal();
  const Eigen::Matrix3d turned = rotated(covariance, std::numbers::pi / 2);
  EXPECT_NEAR(turned(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(turned(1, 1), 4.0, 1e-12);
  EXPECT_NEAR(turned(2, 2), 0.25, 1e-12);
  covariance(0, 1) = covariance(1, 0) = 0.5;
  EXPECT_LT((inverted(covariance, 0.0) * covariance - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(inverted(Eigen::Matrix3d::Zero())(1, 1), 1e6, 1e-3);
}

// A frame 2 m to the left sees a turn of the other one as a move along x.
TEST(Covariance, TransformedIsTheAdjoint) {
  const Eigen::Matrix3d error = Eigen::Vector3d(0.0, 0.0, 0.01).asDiagonal();
  const Eigen::Matrix3d seen = transformed(error, {0, 2, 0});
  EXPECT_NEAR(seen(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(seen(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(seen(0, 2), 0.02, 1e-12);
}

// P(chi2 of 3 degrees of freedom > q) = erfc(sqrt(q/2)) + sqrt(2 q / pi) exp(-q/2).
TEST(Covariance, TheQuantilesAreThoseOfChiSquare) {
  const auto beyond = [](double q) {
    return std::erfc(std::sqrt(q / 2)) + std::sqrt(2 * q / std::numbers::pi) * std::exp(-q / 2);
  };
  EXPECT_NEAR(beyond(kChi2Dof3Quantile999), 0.001, 1e-6);
  EXPECT_NEAR(beyond(kChi2Dof3Quantile75), 0.25, 1e-3);
}

}  // namespace
}  // namespace marco::slam
