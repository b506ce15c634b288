#include "lcmtypes/channels.hpp"

#include <gtest/gtest.h>

namespace marco {
namespace {

TEST(Orders, AreWhatALiveRobotObeys) {
  for (const char* order :
       {channels::kBaseCommand, channels::kPanTiltCommand, channels::kSlamCommand,
        channels::kEmergencyStop, channels::kSimFault, channels::kGamepad, "PM_ORDERS"}) {
    EXPECT_TRUE(channels::is_order(order)) << order;
  }
  for (const char* other : {channels::kLidar, channels::kOdometry, channels::kBaseStatus,
                            channels::kMapRequest, "BASE_COMMAND_2", "BASE", ""}) {
    EXPECT_FALSE(channels::is_order(other)) << other;
  }
}

}  // namespace
}  // namespace marco
