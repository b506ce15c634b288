#include "lcm_tools/process/batch_bus.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/tests/support/encoded.hpp"
#include "robot/pose2_t.hpp"

namespace marco::process {
namespace {

robot::pose2_t pose_at(int64_t utime, double x_m) {
  robot::pose2_t pose{};
  pose.utime = utime;
  pose.x_m = x_m;
  return pose;
}

TEST(BatchBus, PublishedMessagesFollowAfterTheRunningHandler) {
  BatchBus bus;
  DropCounter drops;
  std::vector<std::string> order;
  bus.subscribe<robot::pose2_t>("A", drops, [&](const robot::pose2_t& pose, const RawMessage&) {
    bus.publish("B", pose_at(pose.utime, 2.0));
    order.push_back("A");
  });
  bus.subscribe<robot::pose2_t>("B", drops, [&](const robot::pose2_t& pose, const RawMessage& raw) {
    EXPECT_EQ(pose.x_m, 2.0);
    EXPECT_EQ(raw.event_time.us, 5);
    order.push_back("B");
  });
  bus.deliver("A", testing::encoded(pose_at(5, 1.0)), Utime::from_us(9));
  EXPECT_THAT(order, ::testing::ElementsAre("A", "B"));
}

TEST(BatchBus, CountsWhatDoesNotDecodeAndWhatAHandlerRefuses) {
  BatchBus bus;
  DropCounter drops;
  bus.subscribe<robot::pose2_t>("A", drops, [](const robot::pose2_t& pose, const RawMessage&) {
    require(pose.x_m == 1.0, "x is not 1");
  });
  std::vector<uint8_t> good = testing::encoded(pose_at(5, 1.0));
  std::vector<uint8_t> cut(good.begin(), good.end() - 1);
  std::vector<uint8_t> long_one = good;
  long_one.push_back(0);
  bus.deliver("A", good, {});
  bus.deliver("A", cut, {});
  bus.deliver("A", long_one, {});
  bus.deliver("A", testing::encoded(pose_at(5, 3.0)), {});
  EXPECT_EQ(drops.received(), 4);
  EXPECT_EQ(drops.by_cause().at("undecodable"), 2);
  EXPECT_EQ(drops.by_cause().at("x is not 1"), 1);
}

TEST(BatchBus, AChannelPatternMatchesTheWholeName) {
  BatchBus bus;
  int heard = 0;
  bus.subscribe_raw("LIDAR(_[A-Z]+)?", [&](const RawMessage&) { ++heard; });
  for (const char* channel : {"LIDAR", "LIDAR_REAR", "XLIDAR", "LIDAR_2"}) {
    bus.deliver(channel, {}, {});
  }
  EXPECT_EQ(heard, 2);
}

}  // namespace
}  // namespace marco::process
