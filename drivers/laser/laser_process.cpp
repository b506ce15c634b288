#include "drivers/laser/laser_process.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "common/pose2.hpp"
#include "drivers/laser/regular_scan.hpp"
#include "drivers/process/driver_loop.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco::drivers {
namespace {

using std::chrono::steady_clock;
// Range noise makes every scan differ from the last. Ten equal scans mean a frozen device.
constexpr int kStuckAfter = 10;
// After a stall the kernel's buffers hold bytes of unknown age. kDrain is enough to read them out.
constexpr std::chrono::milliseconds kStall{500}, kDrain{300};

/// Steps one laser driver and publishes its scans: lidar_raw_t with the time of every beam first,
/// then planar_lidar_t with the same utime.
class LaserSession final : public DeviceSession {
 public:
  /// Outlives the session.
  struct Outlet {
    process::Bus& bus;
    process::DropCounter& drops;
    const LaserProcess& laser;
    std::optional<LaserProperties>& properties;  ///< kept up to date for SENSOR_INFO
  };

  /// @param stream  the driver's; outlives the session.
  LaserSession(ByteStream& stream, std::unique_ptr<LaserDriver> driver, Outlet outlet);

  void step() override;
  std::string state() const override;
  bool answers() const override { return driver_->answers(); }
  void stop() override { driver_->stop(); }

 private:
  void flush_input();
  void watch(const LaserScan& scan);
  void publish(ArrivedScan& arrived);
  void count_drops();

  ByteStream& stream_;
  std::unique_ptr<LaserDriver> driver_;
  Outlet outlet_;
  std::map<std::string, int64_t> counted_drops_;
  std::vector<float> last_ranges_m_;
  int repetitions_ = 0;  ///< of the same ranges
  std::chrono::steady_clock::time_point last_step_;
};

LaserSession::LaserSession(ByteStream& stream, std::unique_ptr<LaserDriver> driver, Outlet outlet)
    : stream_(stream),
      driver_(std::move(driver)),
      outlet_(outlet),
      last_step_(steady_clock::now()) {
  outlet_.properties = driver_->properties();
}

void LaserSession::step() {
  std::vector<ArrivedScan> scans = driver_->step();
  const auto now = steady_clock::now();
  if (now - std::exchange(last_step_, now) > kStall) {  // most likely while it waited for bytes
    flush_input();
    scans.clear();
  }
  for (ArrivedScan& arrived : scans) publish(arrived);
  count_drops();
  outlet_.properties = driver_->properties();
}

std::string LaserSession::state() const {
  if (repetitions_ < kStuckAfter) return driver_->state();
  return driver_->state() + ", but stuck: repeats the same scan " +
         std::to_string(repetitions_ + 1) + " times";
}

void LaserSession::flush_input() {
  outlet_.drops.count_received();
  outlet_.drops.count("this process stalled: queued input is too old");
  const auto until = steady_clock::now() + kDrain;
  uint8_t old[4096];
  while (steady_clock::now() < until) stream_.read(old, std::chrono::milliseconds(20));
  driver_->on_input_flushed();
  last_step_ = steady_clock::now();
}

void LaserSession::watch(const LaserScan& scan) {
  repetitions_ = scan.ranges_m == last_ranges_m_ ? repetitions_ + 1 : 0;
  if (repetitions_ == 0) last_ranges_m_ = scan.ranges_m;
}

void LaserSession::publish(ArrivedScan& arrived) {
  outlet_.drops.count_received();
  watch(arrived.scan);
  const std::string lidar = channels::lidar_of(outlet_.laser.place.channel);
  lidar_raw_t raw = to_raw_message(arrived.scan);
  if (arrived.intensities.size() == arrived.scan.size()) raw.intensities = arrived.intensities;
  outlet_.bus.publish(channels::raw_channel_of(lidar), raw);
  outlet_.bus.publish(lidar, to_message(regular_scan(arrived.scan)));
  add_latency((wall_now() - arrived.arrival).seconds());
}

void LaserSession::count_drops() {
  for (const auto& [cause, count] : driver_->counts().drops) {
    for (int64_t& counted = counted_drops_[cause]; counted < count; ++counted) {
      outlet_.drops.count_received();
      outlet_.drops.count(cause);
    }
  }
}

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
