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

TEST(LcmBus, AnUrlNobodyKnowsIsRefusedWithAHint) {
  EXPECT_THROW(LcmBus("nonsense://"), std::runtime_error);
}

}  // namespace
}  // namespace marco::process
