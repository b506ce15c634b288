#include "common/input/stamp_repair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace marco {
namespace {

double repaired_s(StampRepair& stamps, double stamp_s) {
  return stamps.repair(Utime::from_seconds(stamp_s)).seconds();
}

TEST(StampRepair, RegularAndJitteredStampsStayAsTheyAre) {
  for (const double jitter_s : {0.0, 0.01}) {
    StampRepair stamps;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off_s(-jitter_s, jitter_s);
    for (int i = 0; i < 200; ++i) {
      const double stamp_s = 0.1 * i + off_s(random);
      EXPECT_NEAR(repaired_s(stamps, stamp_s), stamp_s, 1e-6) << i;
    }
    EXPECT_NEAR(stamps.period_s(), 0.1, 0.01);
  }
}

// Every fourth to sixth scan is stamped a millisecond after the one before.
TEST(StampRepair, StampsOfAStalledLoggerLieOnTheirBeat) {
  StampRepair stamps;
  for (int i = 0; i < 60; ++i) {
    const bool stalled = i % 6 > 2;
    const double stamp_s = stalled ? 0.2 * (i - i % 6 + 2) + 0.001 * (i % 6 - 2) : 0.2 * i;
    const double lies_s = repaired_s(stamps, stamp_s);
    // While the period is being learnt it may be too short.
    if (i > 12) {
      EXPECT_NEAR(lies_s, 0.2 * i, 0.06) << i;
      EXPECT_NEAR(stamps.period_s(), 0.2, 0.001) << i;
    }
  }
}

// What is within 0.15 periods, and 5 ms, no laser can do; but where scans are missing, one may come
// soon after another.
TEST(StampRepair, OnlyStampsNearlyAlikeAreThoseOfAStalledLogger) {
  const auto repaired_after = [](double period_s, double step_s) {
    StampRepair stamps;
    for (int i = 0; i <= 20; ++i) repaired_s(stamps, period_s * i);
    return repaired_s(stamps, 20 * period_s + step_s) - 20 * period_s;
  };
  EXPECT_NEAR(repaired_after(0.2, 0.004), 0.2, 0.001);
  EXPECT_NEAR(repaired_after(0.2, 0.008), 0.008, 1e-6);
  EXPECT_NEAR(repaired_after(0.02, 0.002), 0.02, 0.001);
  EXPECT_NEAR(repaired_after(0.02, 0.004), 0.004, 1e-6);
}

TEST(StampRepair, AfterEightRepairedScansTheStampsAreBelieved) {
  StampRepair stamps;
  for (int i = 0; i <= 20; ++i) repaired_s(stamps, 0.1 * i);
  for (int i = 1; i <= 8; ++i) EXPECT_NEAR(repaired_s(stamps, 2.0 + 1e-4 * i), 2.0 + 0.1 * i, 0.01);
  EXPECT_NEAR(repaired_s(stamps, 2.0 + 9e-4), 2.0 + 9e-4, 1e-6);
}

// That is what odometry which was looked up by the stamps is off.
TEST(StampRepair, AStampLeavesItsBeatByAsMuchMoreAsTheOneBefore) {
  StampRepair stamps;
  for (int i = 0; i <= 20; ++i) {
    repaired_s(stamps, 0.2 * i);
    EXPECT_NEAR(stamps.off_beat(), 0.0, 1e-6);
  }
  for (int i = 1; i <= 2; ++i) {
    repaired_s(stamps, 4.0 + 0.001 * i);
    EXPECT_NEAR(stamps.off_beat(), 1.0, 0.01) << i;
  }
  repaired_s(stamps, 4.6);
  EXPECT_NEAR(stamps.off_beat(), 2.0, 0.02) << "it came back";
  repaired_s(stamps, 4.8);
  EXPECT_NEAR(stamps.off_beat(), 0.0, 0.01);
  repaired_s(stamps, -100.0);
  EXPECT_NEAR(stamps.off_beat(), 10.0, 0.01) << "the clock was set: no further";
}

TEST(StampRepair, ThePeriodFollowsALaserThatTurnsFaster) {
  StampRepair stamps;
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 0.2 * i);
  for (int i = 0; i < 40; ++i) repaired_s(stamps, 4.0 + 0.15 * i);
  EXPECT_NEAR(stamps.period_s(), 0.15, 0.001);
}

TEST(StampRepair, AStampThatStepsBackASecondIsRepaired) {
  StampRepair stamps;
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 0.2 * i);
  EXPECT_NEAR(repaired_s(stamps, 4.0 - 0.9), 4.0, 0.01);
  EXPECT_NEAR(repaired_s(stamps, 4.2), 4.2, 1e-6);
}

// Four of five scans at random: the next may come long before the mean interval is over.
TEST(StampRepair, WhereScansAreMissingStampsStayAsTheyAre) {
  StampRepair stamps;
  std::mt19937 random(4);
  std::bernoulli_distribution missing(0.8);
  for (int i = 0; i < 2000; ++i) {
    if (missing(random)) continue;
    EXPECT_NEAR(repaired_s(stamps, 0.2 * i), 0.2 * i, 1e-6) << i;
  }
}

TEST(StampRepair, AGapIsBelieved) {
  StampRepair stamps;
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 0.1 * i);
  EXPECT_NEAR(repaired_s(stamps, 7.0), 7.0, 1e-6);
  EXPECT_NEAR(repaired_s(stamps, 7.1), 7.1, 1e-6);
  EXPECT_NEAR(stamps.period_s(), 0.1, 0.004) << "one gap is no other period";
}

TEST(StampRepair, AClockThatWasSetBackIsBelievedAtOnceOrAfterTwoPeriods) {
  StampRepair stamps;
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 100.0 + 0.1 * i);
  EXPECT_NEAR(repaired_s(stamps, 100.4), 100.4, 1e-6) << "by 16 periods: no stall lasts so long";
  EXPECT_NEAR(repaired_s(stamps, 5.0), 5.0, 1e-6);
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 5.1 + 0.1 * i);
  // By less than a stall may last: 7.1 comes next, 6.7 is stamped.
  EXPECT_NEAR(repaired_s(stamps, 6.7), 7.1, 0.01);
  EXPECT_NEAR(repaired_s(stamps, 6.8), 7.2, 0.01);
  EXPECT_NEAR(repaired_s(stamps, 6.9), 6.9, 1e-6);
  EXPECT_NEAR(repaired_s(stamps, 7.0), 7.0, 1e-6);
}

}  // namespace
}  // namespace marco
