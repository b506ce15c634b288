#include "lcm_tools/spy/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace marco::spy {
namespace {

constexpr int64_t kSecondUs = 1'000'000;

/// Messages at each of these offsets, each period anew.
RateMeter bursts(int64_t period_us, const std::vector<int64_t>& offsets_us, int periods) {
  RateMeter meter;
  for (int i = 0; i < periods; ++i) {
    for (const int64_t offset_us : offsets_us) meter.add(period_us * i + offset_us, 50);
  }
  return meter;
}

TEST(RateMeter, ASteadyChannelHasItsRateAndNoJitter) {
  const RateMeter meter = bursts(10000, {0}, 500);
  const Rates recent = meter.recent(10000 * 500);
  EXPECT_NEAR(recent.hz, 100, 1e-9);
  EXPECT_NEAR(recent.bytes_per_s, 5000, 1e-6);
  EXPECT_EQ(recent.jitter_s, 0);
  EXPECT_NEAR(meter.overall(10000 * 500).hz, 100, 1e-9);
}

TEST(RateMeter, ABurstCountsWholeWithTheSilenceBeforeIt) {
  std::vector<int64_t> ten;
  for (int i = 0; i < 10; ++i) ten.push_back(70 * i);
  for (const int periods : {2, 3, 4, 40}) {
    const RateMeter meter = bursts(kSecondUs, ten, periods);
    for (const int64_t age_us : {0, 100'000, 500'000, 999'000, 1'400'000}) {
      const int64_t now_us = meter.last_us() + age_us;
      EXPECT_NEAR(meter.recent(now_us).hz, 10, 1e-9) << periods << " " << age_us;
      EXPECT_NEAR(meter.recent(now_us).bytes_per_s, 500, 1e-9);
      EXPECT_NEAR(meter.overall(now_us).hz, 10, 1e-9) << periods << " " << age_us;
    }
  }
  // Two lasers' SENSOR_INFO once a second; tiles of a map every 5 s; two bursts a second that take
  // 60 ms each.
  EXPECT_NEAR(bursts(kSecondUs, {0, 30}, 9).recent(9 * kSecondUs).hz, 2, 1e-9);
  EXPECT_NEAR(bursts(5 * kSecondUs, ten, 3).recent(14 * kSecondUs).hz, 2, 1e-9);
  EXPECT_NEAR(bursts(kSecondUs / 2, {0, 30000, 60000}, 30).recent(15 * kSecondUs).hz, 6, 1e-9);
  // A burst longer than a cluster may be.
  std::vector<int64_t> long_burst;
  for (int i = 0; i < 400; ++i) long_burst.push_back(1000 * i);
  EXPECT_NEAR(bursts(kSecondUs, long_burst, 9).recent(9 * kSecondUs).hz, 400, 1e-9);
}

TEST(RateMeter, TwoASecondAreTwo) {
  for (const int count : {3, 5, 50}) {
    const RateMeter meter = bursts(kSecondUs / 2, {0}, count);
    EXPECT_NEAR(meter.recent(meter.last_us() + 400'000).hz, 2, 1e-9) << count;
    EXPECT_NEAR(meter.overall(meter.last_us() + 400'000).hz, 2, 1e-9) << count;
  }
}

// What --once shows of a single burst: not the rate inside it.
TEST(RateMeter, OneBurstAloneIsNoRateOfItsOwn) {
  const RateMeter meter = bursts(1, {0, 20, 40, 60}, 1);
  EXPECT_NEAR(meter.overall(2 * kSecondUs).hz, 2, 1e-6);
  EXPECT_NEAR(meter.recent(2 * kSecondUs).hz, 2, 1e-6);
}

TEST(RateMeter, JitterIsLongestMinusShortestIntervalOfTheLastTwoSeconds) {
  RateMeter meter;
  meter.add(0, 1);
  meter.add(3'000'000, 1);  // the long interval ends too long ago
  for (int i = 1; i <= 40; ++i) meter.add(3'000'000 + 100000 * i + (i == 39 ? 20000 : 0), 1);
  // Intervals of 100, 120 and 80 ms.
  EXPECT_NEAR(meter.recent(7'000'000).jitter_s, 0.04, 1e-9);
  EXPECT_NEAR(meter.overall(7'000'000).jitter_s, 3 - 0.08, 1e-9);
}

TEST(RateMeter, ASlowOrSilentChannelFallsTowardsZero) {
  RateMeter meter;
  meter.add(0, 10);
  EXPECT_EQ(meter.recent(5'000'000).hz, 0);
  meter.add(5'000'000, 10);
  EXPECT_NEAR(meter.recent(5'100'000).hz, 0.2, 1e-9);
  EXPECT_NEAR(meter.recent(25'000'000).hz, 0.05, 1e-9);
  EXPECT_NEAR(meter.recent(25'000'000).bytes_per_s, 0.5, 1e-9);
  EXPECT_FALSE(meter.silent(12'000'000));
  EXPECT_TRUE(meter.silent(13'000'000));
  RateMeter steady = bursts(10000, {0}, 500);
  const int64_t last_us = steady.last_us();
  EXPECT_NEAR(steady.recent(last_us + 900'000).hz, 50, 8);  // half of 2 s, by clusters of 250 ms
  EXPECT_NEAR(steady.recent(last_us + 10 * kSecondUs).hz, 0.1, 1e-9);
  EXPECT_FALSE(steady.silent(last_us + 900'000));
  EXPECT_TRUE(steady.silent(last_us + 1'100'000));
}

TEST(RateMeter, WildTimesDoNoHarm) {
  RateMeter meter;
  for (const int64_t time : {INT64_MAX, INT64_MIN, int64_t{0}, int64_t{-1}, INT64_MAX})
    meter.add(time, 1);
  EXPECT_EQ(meter.count(), 5);
  EXPECT_GE(meter.recent(INT64_MIN).hz, 0);
  EXPECT_GE(meter.overall(INT64_MIN).hz, 0);
  EXPECT_FALSE(meter.silent(INT64_MAX));
}

// --- the slow oracle: every arrival is kept, and all is looked for anew ---

struct Oracle {
  std::vector<int64_t> times_us;

  std::vector<std::size_t> cluster_ends() const {
    std::vector<std::size_t> ends;
    std::size_t begin = 0;
    for (std::size_t i = 1; i <= times_us.size(); ++i) {
      const bool closed = i == times_us.size() || times_us[i] - times_us[i - 1] >= 20000 ||
                          times_us[i] - times_us[begin] >= 250000;
      if (!closed) continue;
      ends.push_back(i - 1);
      begin = i;
    }
    return ends;
  }
  // The last message of a cluster that ended by `time_us`, or -1.
  int64_t end_by(int64_t time_us) const {
    int64_t result = -1;
    for (const std::size_t end : cluster_ends()) {
      if (times_us[end] <= time_us) result = static_cast<int64_t>(end);
    }
    return result;
  }
  std::vector<int64_t> pauses(std::size_t from) const {
    std::vector<int64_t> result;
    for (std::size_t i = from + 1; i < times_us.size(); ++i)
      result.push_back(times_us[i] - times_us[i - 1]);
    return result;
  }
  Rates rates(int64_t start, int64_t from_us, int64_t to_us, std::size_t pauses_from) const {
    const auto all = pauses(pauses_from);
    const auto [shortest, longest] = std::minmax_element(all.begin(), all.end());
    Rates result;
    result.jitter_s = static_cast<double>(*longest - *shortest) * 1e-6;
    const auto count = static_cast<int64_t>(times_us.size()) - 1 - start;
    const double span_s = static_cast<double>(to_us - from_us) * 1e-6;
    result.hz = span_s > 0 ? static_cast<double>(std::max<int64_t>(1, count)) / span_s : 0;
    return result;
  }
  Rates recent(int64_t now_us) const {
    const int64_t last_us = times_us.back();
    const int64_t start = end_by(last_us - 1'900'000);
    const auto from = static_cast<std::size_t>(std::max<int64_t>(0, start));
    const auto all = pauses(from);
    const int64_t longest_us = *std::max_element(all.begin(), all.end());
    const bool explained = 2 * (now_us - last_us) <= 3 * longest_us;
    if (start >= 0 && explained) return rates(start, times_us[from], last_us, from);
    if (start >= 0) {
      const int64_t quiet = end_by(now_us - 1'900'000);
      return rates(quiet, times_us[static_cast<std::size_t>(quiet)], now_us, from);
    }
    if (!explained) return rates(-1, times_us[0], now_us, 0);
    const auto pause = std::max_element(all.begin(), all.end()) - all.begin();  // the first of them
    return rates(pause, times_us[static_cast<std::size_t>(pause)], last_us, 0);
  }
};

// Random processes of all kinds: steady with jitter, Poisson, bursts of random size, pauses.
int64_t next_interval_us(std::mt19937& random, int kind) {
  const double uniform = std::uniform_real_distribution<>(0, 1)(random);
  switch (kind % 5) {
    case 0:
      return 10000 + static_cast<int64_t>(2000 * uniform);
    case 1:
      return static_cast<int64_t>(-100000 * std::log1p(-uniform));  // Poisson, 10 Hz
    case 2:
      return uniform < 0.9 ? static_cast<int64_t>(500 * uniform) : 1'000'000;
    case 3:
      return static_cast<int64_t>(1000 * std::pow(10.0, 4 * uniform));  // 1 ms to 10 s
    default:
      return static_cast<int64_t>(-300 * std::log1p(-uniform));  // Poisson, 3333 Hz
  }
}

TEST(RateMeter, AgreesWithTheSlowOneOnRandomArrivals) {
  std::mt19937 random(31);
  for (int kind = 0; kind < 40; ++kind) {
    RateMeter meter;
    Oracle oracle;
    int64_t time_us = 1'000'000'000;
    for (int i = 0; i < 200; ++i) {
      time_us += std::max<int64_t>(i == 0 ? 0 : 1, next_interval_us(random, kind));
      meter.add(time_us, 10);
      oracle.times_us.push_back(time_us);
      if (i == 0 || random() % 4 != 0) continue;
      const int64_t now_us =
          time_us + next_interval_us(random, kind + static_cast<int>(random() % 2));
      const Rates fast = meter.recent(now_us), slow = oracle.recent(now_us);
      ASSERT_NEAR(fast.hz, slow.hz, 1e-9 * slow.hz) << "kind " << kind << ", message " << i;
      ASSERT_NEAR(fast.jitter_s, slow.jitter_s, 1e-9) << "kind " << kind << ", message " << i;
    }
  }
}

// The mean over many moments is the rate the messages were made with.
TEST(RateMeter, OfRandomArrivalsTheMeanIsRight) {
  std::mt19937 random(7);
  for (const double hz : {2.0, 30.0, 500.0}) {
    RateMeter meter;
    std::exponential_distribution<> interval_s(hz);
    double time_s = 0, sum = 0;
    int looks = 0;
    for (double next_look_s = 5; next_look_s < 400;) {
      const double next_s = time_s + interval_s(random);
      for (; next_look_s < std::min(next_s, 400.0); next_look_s += 0.1, ++looks)
        sum += meter.recent(static_cast<int64_t>(1e6 * next_look_s)).hz;
      time_s = next_s;
      meter.add(static_cast<int64_t>(1e6 * time_s), 1);
    }
    // 800 messages or more: 3.5 %; of few messages in a window the mean of counts over times that
    // end with a message is a little high.
    EXPECT_NEAR(sum / looks, hz, 0.15 * hz) << hz;
  }
}

}  // namespace
}  // namespace marco::spy
