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
