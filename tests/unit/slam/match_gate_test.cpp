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

TEST(ProvesLie, MoreOfTheScanThanChanceExplains) {
  EXPECT_TRUE(proves_lie(0.88, 0.67, 240));
  EXPECT_FALSE(proves_lie(0.77, 0.65, 26)) << "three beams";
  EXPECT_FALSE(proves_lie(0.74, 0.65, 100000)) << "of many beams a little is no proof either";
}

}  // namespace
}  // namespace marco::slam
