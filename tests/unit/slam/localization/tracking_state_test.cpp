#include "slam/localization/localizer.hpp"

#include <gtest/gtest.h>

namespace marco::slam {
namespace {

using Verdict = TrackingState::Verdict;

class TrackingStateTest : public ::testing::Test {
 protected:
  TrackingStateTest() { state_.begin(Utime::from_us(0)); }
  // A scan every 0.1 s.
  bool lost_after(Verdict verdict, double moved_m, bool moves_fit = true) {
    now_ = now_ + Duration::from_seconds(0.1);
    return state_.is_lost_after(now_, verdict, moves_fit, moved_m, {1.0, 5.0, 30.0});
  }
  TrackingState state_;
  Utime now_ = Utime::from_us(0);
};

TEST_F(TrackingStateTest, ARobotIsLostAfterAMetreOfContradiction) {
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(lost_after(Verdict::contradicted, 0.099));
  EXPECT_TRUE(lost_after(Verdict::contradicted, 0.099));
  EXPECT_EQ(state_.times_lost(), 1);
}

TEST_F(TrackingStateTest, AScanThatSaysNothingEndsTheContradiction) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(lost_after(i % 5 == 4 ? Verdict::says_nothing : Verdict::contradicted, 0.2));
  }
}

TEST_F(TrackingStateTest, ARobotThatStandsIsLostAfterFiveSecondsOfContradiction) {
  int scans = 0;
  while (!lost_after(Verdict::contradicted, 0.0) && scans < 100) ++scans;
  EXPECT_EQ(scans, 50);
}

TEST_F(TrackingStateTest, WhereTheMapIsSilentThePathIsBelievedFor30Metres) {
  int scans = 0;
  while (!lost_after(Verdict::says_nothing, 0.5) && scans < 100) ++scans;
  EXPECT_EQ(scans, 60);
}

// Scans that do not fit each other may have been taken anywhere: silence is no comfort until the
// map confirms again.
TEST_F(TrackingStateTest, AfterScansThatDoNotFitEachOtherSilenceCountsAsContradiction) {
  EXPECT_FALSE(lost_after(Verdict::says_nothing, 0.4, false));
  EXPECT_FALSE(lost_after(Verdict::says_nothing, 0.4));
  EXPECT_TRUE(lost_after(Verdict::says_nothing, 0.4));
  state_.begin(now_);
  EXPECT_FALSE(lost_after(Verdict::says_nothing, 0.4, false));
  EXPECT_FALSE(lost_after(Verdict::confirmed, 0.4));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(lost_after(Verdict::says_nothing, 0.4));
}

}  // namespace
}  // namespace marco::slam
