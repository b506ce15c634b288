#pragma once

#include <functional>

#include "common/input/sensor_synchronizer.hpp"
#include "lcm_tools/process/bus.hpp"

namespace marco {

struct FeedOptions {
  std::function<bool(const LaserScan&)> accept;  ///< whether a scan is wanted at all; may be empty
  std::function<void()> after;  ///< called after each scan or sample: scans may be complete now
};

/// The channel names of lcmtypes/channels.hpp.
ChannelNames lcm_channel_names();

/// Subscribes to every LIDAR and LIDAR_RAW channel, SENSOR_INFO, PANTILT_STATE, ODOMETRY and IMU.
/// Messages are decoded into `synchronizer`; bad ones are counted in `drops`. The synchronizer and
/// `drops` outlive the bus's subscriptions.
void feed(process::Bus& bus,
          process::DropCounter& drops,
          SensorSynchronizer& synchronizer,
          const FeedOptions& options);

}  // namespace marco
