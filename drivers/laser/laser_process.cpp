#include "drivers/laser/laser_process.hpp"

#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "common/pose2.hpp"
#include "drivers/laser/laser_session.hpp"
#include "drivers/process/driver_loop.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco::drivers {
namespace {

/// A line without a device, for a driver that only checks its options.
class NoLine final : public ByteStream {
 public:
  std::size_t read(std::span<uint8_t>, std::chrono::microseconds) override { return 0; }
  void write(std::span<const uint8_t>) override {}
  void set_line(const LineSettings&) override {}
  void discard_input() override {}
};

}  // namespace

SensorInfo sensor_info(const LaserPlace& place, const LaserProperties& properties, Utime now) {
  require(place.mount == "robot" || place.mount == "pantilt",
          "mount is 'robot' or 'pantilt', not '" + place.mount + "'");
  require(place.position_m.size() == 3 && place.roll_pitch_yaw_deg.size() == 3,
          "position_m and roll_pitch_yaw_deg have three numbers each");
  SensorInfo info;
  info.utime = now;
  info.channel = channels::lidar_of(place.channel);
  info.mount = place.mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  info.parent_from_sensor =
      make_pose3({place.position_m[0], place.position_m[1], place.position_m[2]},
                 deg_to_rad(place.roll_pitch_yaw_deg[0]), deg_to_rad(place.roll_pitch_yaw_deg[1]),
                 deg_to_rad(place.roll_pitch_yaw_deg[2]));
  info.scan_duration_s = properties.scan_duration_s;
  info.range_min_m = properties.range_min_m;
  // Rounded as the ranges are: a "no return" must not lie a rounding error below the limit.
  info.range_max_m = static_cast<double>(static_cast<float>(properties.range_max_m));
  info.range_sigma_m = properties.range_sigma_m;
  return info;
}

void run_laser(process::Bus& bus, const LaserProcess& laser, const std::function<bool()>& stop) {
  // Options are checked before any device is opened.
  sensor_info(laser.place, {}, wall_now());
  NoLine no_line;
  laser.start(no_line);
  process::DropCounter drops([](const std::string& line) { spdlog::warn("{}", line); });
  std::optional<LaserProperties> properties;
  DriverLoopOptions options;
  options.process = laser.process;
  options.address = laser.address;
  options.line = laser.line;
  options.open = laser.open;
  options.every_second = [&] {
    if (!properties) return;
    bus.publish(channels::kSensorInfo,
                to_message(sensor_info(laser.place, *properties, wall_now())));
  };
  DriverLoop loop(bus, drops, options, [&](ByteStream& stream) {
    return std::make_unique<LaserSession>(stream, laser.start(stream),
                                          LaserSession::Outlet{bus, drops, laser, properties});
  });
  loop.run(stop);
  spdlog::info("{}", drops.summary());
}

int run_laser_until_stopped(const process::CommonArguments& arguments, const LaserProcess& laser) {
  process::start_logging(laser.process, arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  bus.keep_going_without_network();
  const std::string lidar = channels::lidar_of(laser.place.channel);
  spdlog::info("{} on {} and {} of {}", laser.address, lidar, channels::raw_channel_of(lidar),
               process::effective_lcm_url(arguments.lcm_url));
  run_laser(bus, laser, process::stop_requested);
  return 0;
}

}  // namespace marco::drivers
