#include "common/input/rate_watch.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco {
namespace {

Utime at(double seconds) { return Utime::from_seconds(seconds); }

TEST(RateWatch, ASecondSenderIsNoticedOnceAndForgottenWhenItEnds) {
  RateWatch rates;
  int noticed = 0;
  for (int i = 0; i < 300; ++i) {
    noticed += rates.is_new_sender("LIDAR", at(0.1 * i)) ? 1 : 0;
    if (i >= 100 && i < 200) {
      noticed += rates.is_new_sender("LIDAR", at(0.1 * i + 0.03)) ? 1 : 0;
    }
    if (i == 180) {
      EXPECT_EQ(rates.notice(),
                "LIDAR: scans at 20 Hz instead of 10 Hz: is there a second sender?");
    }
  }
  EXPECT_EQ(noticed, 1);
  EXPECT_EQ(rates.notice(), "");
}

TEST(RateWatch, OneLaserWithGapsJitterAndSteppingStampsIsOne) {
  RateWatch rates;
  std::mt19937 random(11);
  std::normal_distribution<double> jitter_s(0.0, 0.03);
  for (int i = 0; i < 2000; ++i) {
    if (i % 300 > 280) continue;
    const double back_s = i % 50 == 49 ? 0.9 : 0.0;
    EXPECT_FALSE(rates.is_new_sender("LIDAR", at(0.2 * i + jitter_s(random) - back_s))) << i;
  }
}

/// Whether twenty seconds of a laser of 10 Hz and then ten of another rate are taken for a second
/// sender.
bool is_noticed(RateWatch& rates, double from_s, double then_hz) {
  bool noticed = false;
  for (int i = 0; i < 200; ++i) noticed |= rates.is_new_sender("LIDAR", at(from_s + 0.1 * i));
  for (double s = 0.0; s < 10.0; s += 1.0 / then_hz) {
    noticed |= rates.is_new_sender("LIDAR", at(from_s + 20.0 + s));
  }
  return noticed;
}

TEST(RateWatch, ASecondSenderOfHalfTheRateIsNoticedAndALittleMoreIsNot) {
  RateWatch half, little;
  EXPECT_TRUE(is_noticed(half, 0.0, 16.0));
  EXPECT_FALSE(is_noticed(little, 0.0, 14.0));
}

TEST(RateWatch, AClockThatWasSetBackIsNoSecondSenderAndHidesNone) {
  RateWatch rates;
  EXPECT_FALSE(is_noticed(rates, 1000.0, 10.0));
  EXPECT_FALSE(is_noticed(rates, 100.0, 10.0));
  EXPECT_TRUE(is_noticed(rates, 200.0, 20.0));
}

// A logger that stalls, and catches up.
TEST(RateWatch, ShortBurstsNowAndThenAreNoSecondSender) {
  RateWatch rates;
  double now_s = 0.0;
  for (int burst = 0; burst < 3; ++burst) {
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(rates.is_new_sender("LIDAR", at(now_s += 0.1)));
    for (int i = 0; i < 60; ++i) EXPECT_FALSE(rates.is_new_sender("LIDAR", at(now_s += 0.05)));
  }
}

TEST(RateWatch, ChannelsHaveTheirOwnRates) {
  RateWatch rates;
  for (int i = 0; i < 2000; ++i) {
    const std::string channel = i % 4 == 0 ? "LIDAR_REAR" : "LIDAR";
    EXPECT_FALSE(rates.is_new_sender(channel, at(0.025 * i))) << i;
  }
  EXPECT_EQ(rates.notice(), "");
}

}  // namespace
}  // namespace marco
