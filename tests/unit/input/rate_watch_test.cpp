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

}  // namespace
}  // namespace marco
