#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "hcs12_base.hpp"

namespace marco::drivers::hcs12 {
namespace {

using testing::Hcs12OnBench;
using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

TEST(Hcs12Driver, AResetEndsTheMoveAndTheNextOneWorks) {
  Hcs12OnBench base;
  base.begin_move(2.0);
  base.bench.run(1.5);
  const int64_t resets = base.driver.resets();
  base.board.reset(base.bench.now());
  EXPECT_TRUE(base.bench.run_until(0.2, [&] { return base.driver.resets() > resets; }));
  EXPECT_EQ(base.driver.status().command, Fate::aborted);
  EXPECT_TRUE(base.comes_up(1.0));
  base.bench.run(0.3);
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TEST(Hcs12Driver, AMoveEndsThoughTheAnswerToItsEndWasLost) {
  Hcs12OnBench base;
  base.begin_move(2.0);  // fast: the firmware says when the wheels rest, and nothing before
  base.bench.run(1.5);
  base.bench.deaf = true;
  base.bench.spoil = [](std::vector<uint8_t>& bytes) { bytes.clear(); };
  base.bench.run(8.0);  // by then the wheels rest
  base.bench.deaf = false;
  base.bench.spoil = nullptr;
  // The walk's own time, a quarter more, a second, and the rest of the way if there is one.
  EXPECT_TRUE(
      base.bench.run_until(12.0, [&] { return base.driver.status().command != Fate::running; }));
  EXPECT_EQ(base.driver.status().command, Fate::done);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 2.0, 0.02);
}

TEST(Hcs12Driver, ASilentBoardIsToldAndTakenUpAgain) {
  Hcs12OnBench base;
  base.bench.deaf = true;
  EXPECT_TRUE(base.bench.run_until(2.0, [&] { return base.driver.status().link == Link::down; }));
  EXPECT_EQ(base.move(0.2, 0.1), Fate::refused);
  base.bench.deaf = false;
  EXPECT_TRUE(base.comes_up(2.0));
  base.bench.run(0.3);
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TEST(Hcs12Driver, APulledPlugEndsTheMove) {
  Hcs12OnBench base;
  base.begin_move(2.0);
  base.bench.run(1.0);
  base.bench.plug(false);
  base.bench.run(0.1);
  EXPECT_EQ(base.driver.status().command, Fate::aborted);
  EXPECT_EQ(base.driver.status().link, Link::down);
  base.bench.plug(true);
  EXPECT_TRUE(base.comes_up(2.0));
  // The board knows nothing of plugs: it is the driver that stops it on its return.
  EXPECT_TRUE(base.bench.run_until(0.3, [&] { return !base.board.motors_on(); }));
}

// A fast move is counted at its end: what was driven of it when the line went, or the host's clock
// was set, and until the board was stopped, is in the board's counters.
TEST(Hcs12Driver, WhatWasDrivenWhileTheLineWasGoneIsCounted) {
  for (const double ahead_s : {0.0, -3600.0, 3600.0}) {
    Hcs12OnBench base;
    base.speed(0.9);
    base.begin_move(3.0);
    base.bench.run(1.5);
    base.bench.plug(false);
    base.bench.host_ahead = Duration::from_seconds(ahead_s);
    base.bench.run(ahead_s == 0.0 ? 0.4 : 0.0);
    base.bench.plug(true);
    EXPECT_TRUE(base.comes_up(2.0));
    base.bench.run(2.0);
    EXPECT_FALSE(base.board.motors_on());
    EXPECT_GT(base.driver.odom_from_robot().x_m, 0.2);
    EXPECT_LE(base.clicks_off(), 1.0) << ahead_s;
    EXPECT_EQ(base.move(0.3), Fate::done);
    EXPECT_LE(base.clicks_off(), 2.0) << ahead_s;
  }
}

TEST(Hcs12Driver, SpoiltBytesAreCountedAndOutlived) {
  Hcs12OnBench base;
  std::mt19937 random(3);
  base.bench.spoil = [&](std::vector<uint8_t>& bytes) {
    if (bytes.empty()) return;
    const auto dice = random() % 60;
    if (dice == 0) bytes[0] = static_cast<uint8_t>(bytes[0] ^ (1U << (random() % 8)));
    if (dice == 1) bytes.erase(bytes.begin());
    if (dice == 2) bytes.push_back(static_cast<uint8_t>(random()));
  };
  for (int i = 0; i < 10; ++i) base.move(0.3);
  EXPECT_GT(base.driver.bad_input() + base.driver.timeouts(), 5);
  base.bench.spoil = nullptr;
  base.bench.run(3.0);
  EXPECT_EQ(base.driver.status().link, Link::up);
  EXPECT_EQ(base.move(0.3), Fate::done);
}

TEST(Hcs12Driver, ShutDownLeavesTheMotorsOff) {
  Hcs12OnBench base;
  base.begin_move(2.0);
  base.bench.run(1.0);
  ASSERT_TRUE(base.board.motors_on());
  std::vector<uint8_t> last_words;
  base.driver.shut_down(last_words);
  base.board.receive(last_words, 9600, base.bench.now());
  std::vector<uint8_t> out;
  base.board.advance(base.bench.now() + Duration::from_seconds(0.01), out);
  EXPECT_FALSE(base.board.motors_on());
}

}  // namespace
}  // namespace marco::drivers::hcs12
