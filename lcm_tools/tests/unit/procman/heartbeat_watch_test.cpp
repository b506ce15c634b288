#include "lcm_tools/procman/heartbeat_watch.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco::procman {
namespace {

constexpr int64_t kHourUs = 3'600'000'000;

TEST(HeartbeatWatch, WhoPromisedNothingIsNotWatched) {
  HeartbeatWatch watch;
  EXPECT_FALSE(watch.next_due_us());
  for (int64_t now_us = 0; now_us < kHourUs; now_us += HeartbeatWatch::kStepUs) {
    ASSERT_FALSE(watch.step(now_us));
  }
}

TEST(HeartbeatWatch, ASilenceOfThreeSecondsOnScheduleIsNoticed) {
  HeartbeatWatch watch;
  int64_t now_us = kHourUs;
  const auto silent_for_us = [&] {
    const int64_t begin_us = now_us;
    while (!watch.step(now_us)) now_us = *watch.next_due_us() + 200;  // as timers are
    return now_us - begin_us;
  };
  watch.step(now_us);
  watch.on_beat(7);
  watch.on_beat(8);
  EXPECT_NEAR(static_cast<double>(silent_for_us()), 3e6, 0.1e6);
  watch.on_beat(7);  // one of two is not enough
  EXPECT_TRUE(watch.step(now_us + 1));
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
    ASSERT_FALSE(watch.step(now_us)) << "after " << now_us << " us";
    now_us += 5'000;
    ASSERT_FALSE(watch.step(now_us));
    if (chance(random) == 0) watch.on_beat(7);
  }
}

}  // namespace
}  // namespace marco::procman
