#include <gmock/gmock.h>
#include <stdlib.h>

#include <random>

#include "drivers/base/order_gate.hpp"
#include "drivers/base/stop_latch.hpp"
#include "drivers/guardian/guardian_watch.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::drivers {
namespace {

using Do = GuardianWatch::Do;
using Watched = GuardianWatch::Driver;
constexpr int64_t kMs = 1'000'000;
constexpr int64_t kBegin = 5'000'000 * kMs;

/// A driver and its guardian in simulated time, by steps of a millisecond, as guardian.cpp does it.
struct World {
  GuardianWatch watch;
  Watched driver{kBegin, true, false, false};
  int64_t now = kBegin;
  bool beats = true;
  bool line_takes = true;
  bool left = false;
  std::vector<int64_t> takes, stops;  ///< when [ms]

  void run(int64_t ms) {
    for (int64_t i = 0; i < ms && !left; ++i) {
      now += kMs;
      if (beats && !driver.is_gone) driver.beat_ns = now;
      const Do what = watch.step(driver, now);
      if (what == Do::take) {
        driver.is_taken = true;
        takes.push_back((now - kBegin) / kMs);
      }
      if (what == Do::take || what == Do::stop) {
        stops.push_back((now - kBegin) / kMs);
        if (line_takes) watch.on_stopped(now);
      }
      left = what == Do::leave;
    }
  }
  void wakes() {
    driver.is_taken = false;
    driver.beat_ns = now;
    beats = true;
  }
};

TEST(GuardianWatch, StopsADriverThatIsSilentForHalfASecond) {
  World world;
  world.run(10'000);
  EXPECT_TRUE(world.stops.empty());
  world.beats = false;
  world.run(2'000);
  ASSERT_EQ(world.takes.size(), 1U);
  EXPECT_EQ(world.takes[0], 10'500);
  EXPECT_EQ(world.stops.size(), 16U);  // ten a second
  world.wakes();
  world.run(10'000);
  EXPECT_EQ(world.stops.size(), 16U);
  world.beats = false;
  world.run(499);
  EXPECT_EQ(world.takes.size(), 1U);
  world.run(2);
  EXPECT_EQ(world.takes.size(), 2U);
}

TEST(GuardianWatch, AnEmergencyStopIsObeyedForADriverThatDoesNotTakeAStep) {
  World world;
  world.watch.on_emergency_stop(world.driver.beat_ns, world.now);
  world.run(1000);
  EXPECT_TRUE(world.stops.empty());  // it does
  world.beats = false;
  world.run(50);
  for (int i = 0; i < 10; ++i) {  // it is said again and again
    world.watch.on_emergency_stop(world.driver.beat_ns, world.now);
    world.run(30);
  }
  ASSERT_FALSE(world.takes.empty());
  EXPECT_EQ(world.takes[0], 1150);
}

TEST(GuardianWatch, StopsForADriverThatIsGoneAndLeaves) {
  World world;
  world.run(1000);
  world.driver.is_gone = true;
  world.run(10'000);
  EXPECT_TRUE(world.left);
  EXPECT_EQ(world.stops.front(), 1001);
  EXPECT_EQ(world.stops.size(), 10U);
  EXPECT_EQ((world.now - kBegin) / kMs, 2001);

  World hung;
  hung.beats = false;
  hung.run(530);
  hung.driver.is_gone = true;  // killed by its supervisor: stopped at once, not at the next turn
  hung.run(1);
  EXPECT_EQ(hung.stops.back(), 531);
  hung.run(3000);
  EXPECT_TRUE(hung.left);

  World blocked;
  blocked.line_takes = false;
  blocked.driver.is_gone = true;
  blocked.run(10'000);
  EXPECT_TRUE(blocked.left);
  EXPECT_EQ((blocked.now - kBegin) / kMs, 5001);
}

TEST(GuardianWatch, WithoutALineThereIsNothingToStop) {
  World world;
  world.driver.shares_line = false;
  world.beats = false;
  world.run(10'000);
  EXPECT_TRUE(world.stops.empty());
  EXPECT_FALSE(world.left);
  world.driver.is_gone = true;
  world.run(1);
  EXPECT_TRUE(world.left);
}

// Whatever stalls there are: each of more than half a second is taken, no other, and the guardian
// never sleeps past a moment at which it has something to do.
TEST(GuardianWatch, TakesEachLongStallAndNoOther) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> stall_ms(1, 2000), work_ms(1, 300);
  World world;
  std::size_t expected = 0;
  for (int i = 0; i < 300; ++i) {
    world.run(work_ms(random));
    world.beats = false;
    const int ms = stall_ms(random);
    for (int t = 0; t < ms; ++t) {
      const int64_t wait_ns = world.watch.wait_ns(world.driver, world.now);
      const std::size_t before = world.stops.size();
      world.run(1);
      const bool has_stopped = world.stops.size() > before;
      EXPECT_TRUE(!has_stopped || wait_ns <= kMs) << wait_ns;
    }
    expected += ms >= 500 ? 1 : 0;
    EXPECT_EQ(world.takes.size(), expected) << ms;
    world.wakes();
  }
}

class StopLatchTest : public ::testing::Test {
 protected:
  StopLatchTest() { setenv("XDG_STATE_HOME", folder_.path().c_str(), 1); }

  marco::testing::TemporaryFolder folder_;
  const EmergencyStop stop_{Utime::from_us(1234567), true, "marco stop", "a child\non the floor"};
};

TEST_F(StopLatchTest, OutlivesItsWriterUntilARelease) {
  const StopLatch latch("create", "");
  EXPECT_FALSE(latch.load());
  latch.save(stop_);
  const auto kept = StopLatch("create", "").load();
  ASSERT_TRUE(kept);
  EXPECT_TRUE(kept->engaged);
  EXPECT_EQ(kept->utime, stop_.utime);
  EXPECT_EQ(kept->sender, "marco stop");
  EXPECT_EQ(kept->reason, "a child on the floor");
  latch.save(std::nullopt);
  latch.save(std::nullopt);
  EXPECT_FALSE(StopLatch("create", "").load());
}

TEST_F(StopLatchTest, IsOfOneBaseInOneNetwork) {
  StopLatch("create", "udpm://239.1.1.1:7667?ttl=0").save(stop_);
  EXPECT_TRUE(StopLatch("create", "udpm://239.1.1.1:7667?ttl=1&recv_buf_size=9").load());
  EXPECT_FALSE(StopLatch("create", "udpm://239.1.1.1:7668?ttl=0").load());
  EXPECT_FALSE(StopLatch("create", "").load());
  EXPECT_FALSE(StopLatch("kobuki", "udpm://239.1.1.1:7667").load());
  StopLatch("create", "udpm://").save(stop_);
  EXPECT_TRUE(StopLatch("create", "udpm://239.255.76.67:7667?ttl=0").load());
}

// Half a file, somebody's folder of that name: whoever wrote it meant a stop.
TEST_F(StopLatchTest, WhatCannotBeReadIsAStopThatAnyReleaseEnds) {
  const StopLatch latch("create", "");
  latch.save(stop_);
  const auto file = *std::filesystem::recursive_directory_iterator(folder_.path() / "marco");
  for (const char* text : {"", "x", "99999999999999999999\n", "9223372036854775807\na\nb"}) {
    std::ofstream(file.path()) << text;
    const auto kept = latch.load();
    ASSERT_TRUE(kept) << text;
    OrderGate gate;
    const Utime now = Utime::from_us(1'000'000'000);
    gate.on_emergency_stop(*kept, now);
    EXPECT_TRUE(gate.stopped()) << text;
    gate.on_emergency_stop({now, false, "me", ""}, now);
    EXPECT_FALSE(gate.stopped()) << text;
  }
  std::filesystem::remove(file.path());
  std::filesystem::create_directory(file.path());
  EXPECT_TRUE(latch.load());
}

TEST_F(StopLatchTest, SaysWhyItCannotBeKept) {
  setenv("XDG_STATE_HOME", "/dev/null", 1);
  EXPECT_THAT(marco::testing::complaint([&] { StopLatch("create", "").save(stop_); }),
              ::testing::HasSubstr("/dev/null"));
  EXPECT_FALSE(StopLatch("create", "").load());
}

}  // namespace
}  // namespace marco::drivers
