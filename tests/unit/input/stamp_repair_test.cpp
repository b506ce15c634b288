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
    }
  }
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
}

TEST(StampRepair, AClockThatWasSetBackIsBelievedAtOnceOrAfterTwoPeriods) {
  StampRepair stamps;
  for (int i = 0; i < 20; ++i) repaired_s(stamps, 100.0 + 0.1 * i);
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
