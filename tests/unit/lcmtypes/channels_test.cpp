#include "lcmtypes/channels.hpp"

#include <gmock/gmock.h>

namespace marco {
namespace {

using ::testing::Contains;
using ::testing::Not;

// A recording that is played must not move a robot.
TEST(Orders, AreWhatALiveRobotObeys) {
  for (const std::string_view order :
       {channels::kBaseCommand, channels::kPanTiltCommand, channels::kSlamCommand,
        channels::kSimFault, channels::kGamepad}) {
    EXPECT_THAT(channels::kRobotOrders, Contains(order));
  }
  for (const std::string_view order : {channels::kEmergencyStop, "PM_ORDERS", "PMD_ORDERS"}) {
    EXPECT_THAT(channels::kToolOrders, Contains(order));
  }
  for (const std::string_view other :
       {channels::kLidar, channels::kOdometry, channels::kBaseStatus, channels::kMapRequest}) {
    EXPECT_THAT(channels::kRobotOrders, Not(Contains(other)));
    EXPECT_THAT(channels::kToolOrders, Not(Contains(other)));
  }
}

TEST(LidarChannels, ALaserHasAPlanarAndARawChannel) {
  const std::pair<const char*, const char*> lasers[] = {{"LIDAR", "LIDAR_RAW"},
                                                        {"LIDAR_FRONT", "LIDAR_RAW_FRONT"},
                                                        {"LIDAR_RAWHIDE", "LIDAR_RAW_RAWHIDE"}};
  for (const auto& [planar, raw] : lasers) {
    EXPECT_EQ(channels::raw_channel_of(planar), raw);
    EXPECT_EQ(channels::lidar_of(raw), planar);
    EXPECT_EQ(channels::lidar_of(planar), planar);
    EXPECT_TRUE(channels::is_raw_lidar(raw));
    EXPECT_FALSE(channels::is_raw_lidar(planar)) << planar;
  }
  // A name of the user's own: whoever set it listens for it.
  EXPECT_EQ(channels::raw_channel_of("RPLIDAR_LASER"), "RPLIDAR_LASER_RAW");
  EXPECT_EQ(channels::raw_channel_of("LID"), "LID_RAW");
}

}  // namespace
}  // namespace marco
