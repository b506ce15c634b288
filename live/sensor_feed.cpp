#include "live/sensor_feed.hpp"

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco {

ChannelNames lcm_channel_names() { return {channels::kPanTiltState, &channels::lidar_of}; }

void feed(process::Bus& bus,
          process::DropCounter& drops,
          SensorSynchronizer& synchronizer,
          const FeedOptions& options) {
  const auto take = [&synchronizer, after = options.after](const auto& message, const auto&) {
    synchronizer.add(from_message(message));
    after();
  };
  bus.subscribe_raw(channels::kLidarPattern,
                    [&synchronizer, &drops, after = options.after,
                     accept = options.accept](const process::RawMessage& raw) {
                      drops.count_received();
                      try {
                        auto sample = decode_sample(std::string(raw.channel), raw.bytes);
                        if (!sample) return drops.count("undecodable");
                        auto& scan = std::get<LaserScan>(*sample);
                        if (accept && !accept(scan)) return;
                        synchronizer.add(std::move(scan));
                        after();
                      } catch (const std::invalid_argument& bad_message) {
                        drops.count(bad_message.what());
                      }
                    });
  bus.subscribe<sensor_info_t>(channels::kSensorInfo, drops, take);
  bus.subscribe<pantilt_state_t>(channels::kPanTiltState, drops, take);
  bus.subscribe<odometry_t>(channels::kOdometry, drops, take);
  bus.subscribe<imu_t>(channels::kImu, drops, take);
}

}  // namespace marco
