#include "common/process/lcm_bus.hpp"

#include <gtest/gtest.h>

#include "lcmtypes/convert.hpp"

namespace marco::process {
namespace {

TEST(LcmBus, DeliversAndSurvivesAHandlerThatThrows) {
  LcmBus bus("memq://");
  DropCounter drops;
  int handled = 0;
  bus.subscribe<pose2_t>("P", drops, [&](const pose2_t& pose, const RawMessage&) {
    if (pose.x_m > 1.0) throw std::runtime_error("too far");
    ++handled;
  });
  pose2_t pose{};
  for (const double x_m : {0.0, 2.0, 1.0}) {
    pose.x_m = x_m;
    bus.publish("P", pose);
  }
  EXPECT_TRUE(bus.handle_once(100));
  EXPECT_THROW(bus.handle_once(100), std::runtime_error);
  EXPECT_TRUE(bus.handle_once(100));
  EXPECT_EQ(handled, 2);
  EXPECT_FALSE(bus.handle_once(0));
}

TEST(LcmBus, WhoIsTooSlowLosesTheOldestAndSaysHowMany) {
  LcmBus bus("memq://");
  DropCounter drops;
  std::vector<std::pair<char, double>> got;
  const auto keep = [&](char who) {
    return [&got, who](const pose2_t& pose, const RawMessage&) { got.emplace_back(who, pose.x_m); };
  };
  bus.subscribe<pose2_t>("FAST", drops, keep('f'));
  bus.subscribe<pose2_t>("SLOW", drops, keep('s'));
  bus.subscribe<pose2_t>("SLOW", drops, keep('t'));
  pose2_t pose{};
  bus.publish("SLOW", pose);
  constexpr int kSent = static_cast<int>(LcmBus::kQueueCapacity) + 7;
  for (int i = 0; i < kSent; ++i) {
    pose.x_m = i;
    bus.publish("FAST", pose);
  }
  pose.x_m = 1e6;
  bus.publish("SLOW", pose);
  int handled = 0;
  while (bus.handle_once(0)) ++handled;

  EXPECT_EQ(handled, kSent - 7 + 2);
  EXPECT_EQ(bus.lost(), (std::map<std::string, int64_t>{{"FAST", 7}}));
  // In the order of arrival; a message with two handlers is one.
  ASSERT_EQ(got.size(), static_cast<std::size_t>(kSent - 7 + 4));
  EXPECT_EQ(got[0], std::make_pair('s', 0.0));
  EXPECT_EQ(got[1], std::make_pair('t', 0.0));
  EXPECT_EQ(got[2], std::make_pair('f', 7.0));
  EXPECT_EQ(got[got.size() - 3], std::make_pair('f', kSent - 1.0));
  EXPECT_EQ(got.back(), std::make_pair('t', 1e6));
}

// A scan for every second odometry: what is left of both must be of the same time.
TEST(LcmBus, WhatCameBeforeTheOldestThatIsLeftGoesOnAllChannels) {
  LcmBus bus("memq://");
  DropCounter drops;
  std::vector<double> scans, odometry, orders;
  const auto keep = [](std::vector<double>& stamps) {
    return [&stamps](const pose2_t& pose, const RawMessage&) { stamps.push_back(pose.x_m); };
  };
  bus.subscribe<pose2_t>("SCAN", drops, keep(scans));
  bus.subscribe<pose2_t>("ODOMETRY", drops, keep(odometry));
  bus.subscribe<pose2_t>("ORDER", drops, keep(orders));
  pose2_t pose{};
  constexpr int kLost = 100;
  constexpr int kSent = static_cast<int>(LcmBus::kQueueCapacity) + kLost;
  for (int i = 0; i < kSent; ++i) {
    pose.x_m = i;
    bus.publish("ODOMETRY", pose);
    if (i % 2 == 0) bus.publish("SCAN", pose);
    if (i % 100 == 1) bus.publish("ORDER", pose);
  }
  while (bus.handle_once(0)) {
  }

  ASSERT_EQ(odometry.size(), LcmBus::kQueueCapacity);
  EXPECT_EQ(odometry.front(), kLost);
  ASSERT_EQ(scans.size(), LcmBus::kQueueCapacity / 2);
  EXPECT_EQ(scans.front(), kLost);
  EXPECT_EQ(orders.size(), kSent / 100U);  // few: none is lost
  EXPECT_EQ(bus.lost(), (std::map<std::string, int64_t>{{"ODOMETRY", kLost}, {"SCAN", kLost / 2}}));
}

TEST(LcmBus, AnUrlNobodyKnowsIsRefusedWithAHint) {
  EXPECT_THROW(LcmBus("nonsense://"), std::runtime_error);
}

}  // namespace
}  // namespace marco::process
