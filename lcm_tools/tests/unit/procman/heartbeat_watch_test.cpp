#include "lcm_tools/procman/heartbeat_watch.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::procman {
namespace {

constexpr int64_t kHourUs = 3'600'000'000;

HeartbeatWatch::Usage sleeping(pid_t) { return {false, 10}; }

TEST(HeartbeatWatch, WhoPromisedNothingIsNotWatched) {
  HeartbeatWatch watch;
  EXPECT_FALSE(watch.next_due_us());
  for (int64_t now_us = 0; now_us < kHourUs; now_us += HeartbeatWatch::kStepUs) {
    ASSERT_FALSE(watch.step(now_us, sleeping));
  }
}

TEST(HeartbeatWatch, ASilenceOfThreeSecondsOnScheduleIsNoticed) {
  HeartbeatWatch watch;
  int64_t now_us = kHourUs;
  const auto silent_for_us = [&] {
    const int64_t begin_us = now_us;
    while (!watch.step(now_us, sleeping)) now_us = *watch.next_due_us() + 200;  // as timers are
    return now_us - begin_us;
  };
  watch.step(now_us, sleeping);
  watch.on_beat(7);
  watch.on_beat(8);
  EXPECT_NEAR(static_cast<double>(silent_for_us()), 3e6, 0.1e6);
  watch.on_beat(7);  // one of two is not enough
  EXPECT_TRUE(watch.step(now_us + 1, sleeping));
  watch.forget(8);
  EXPECT_NEAR(static_cast<double>(silent_for_us()), 3e6, 0.11e6);
}

// As on a machine that swaps, where the watcher is the first to go on after each stall.
TEST(HeartbeatWatch, ItsOwnStallsDoNotCount) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int64_t> stall_us(200'000, 2'000'000);
  std::uniform_int_distribution<int> chance(0, 2);
  HeartbeatWatch watch;
  watch.on_beat(7);
  for (int64_t now_us = 0; now_us < 2 * kHourUs;) {
    now_us += stall_us(random);
    ASSERT_FALSE(watch.step(now_us, sleeping)) << "after " << now_us << " us";
    now_us += 5'000;
    ASSERT_FALSE(watch.step(now_us, sleeping));
    if (chance(random) == 0) watch.on_beat(7);
  }
}

TEST(HeartbeatWatch, WaitingForAProcessorDoesNotCountAndAnEndlessLoopDoes) {
  HeartbeatWatch watch;
  HeartbeatWatch::Usage usage{true, 10};
  const auto usage_of = [&](pid_t) { return usage; };
  watch.on_beat(7);
  int64_t now_us = 0;
  const auto is_silent_after_us = [&](int64_t silent_us, int ticks) {
    bool is_silent = false;
    for (const int64_t end_us = now_us + silent_us; now_us < end_us;) {
      now_us += HeartbeatWatch::kStepUs;
      usage.cpu_ticks += ticks;
      is_silent = watch.step(now_us, usage_of);
    }
    return is_silent;
  };
  EXPECT_FALSE(is_silent_after_us(kHourUs, 0));
  EXPECT_FALSE(is_silent_after_us(2'500'000, 3));
  EXPECT_TRUE(is_silent_after_us(500'000, 3));
  watch.on_beat(7);
  usage.is_runnable = false;  // stopped, frozen, or waiting for a device
  EXPECT_TRUE(is_silent_after_us(3'000'000, 0));
}

}  // namespace
}  // namespace marco::procman
