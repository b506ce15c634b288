#include "drivers/process/laser_process.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/process/driver_loop.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco::drivers {
namespace {

// A laser's noise makes no two scans alike; ten in a row are one that was kept.
constexpr int kAlikeIsStuck = 10;
// Stopped for longer, a process finds bytes in the line's buffers that were measured it cannot know
// when; they are out of them well within kDrain.
constexpr std::chrono::milliseconds kStall{500}, kDrain{300};

/// No line: for a driver that is only asked whether it takes its options.
class NoLine final : public ByteStream {
 public:
  std::size_t read(std::span<uint8_t>, std::chrono::microseconds) override { return 0; }
  void write(std::span<const uint8_t>) override {}
  void set_line(const LineSettings&) override {}
  void discard_input() override {}
};

/// Between one laser driver and the bus.
class LaserSession final : public DeviceSession {
 public:
  struct Outlet {
    process::Bus& bus;
    process::DropCounter& drops;
    const LaserProcess& laser;
    std::function<void(double)> add_latency;
    std::optional<LaserSight>& sight;
  };

  /// @param stream  the driver's.
  LaserSession(ByteStream& stream, std::unique_ptr<LaserDriver> driver, Outlet outlet)
      : stream_(stream), driver_(std::move(driver)), outlet_(std::move(outlet)) {
    outlet_.sight = driver_->sight();
  }

  void step() override {
    std::vector<ArrivedScan> scans = driver_->step();
    const auto now = std::chrono::steady_clock::now();
    if (now - std::exchange(last_step_, now) > kStall) {  // most likely while it waited for bytes
      drop_what_waited();
      scans.clear();
    }
    for (ArrivedScan& arrived : scans) publish(arrived);
    count_drops();
    outlet_.sight = driver_->sight();
  }
  std::string state() const override {
    if (alike_ < kAlikeIsStuck) return driver_->state();
    return driver_->state() + ", but stuck: the same scan " + std::to_string(alike_ + 1) + " times";
  }
  bool answers() const override { return driver_->answers(); }
  void stop() override { driver_->stop(); }

 private:
  void drop_what_waited() {
    outlet_.drops.count_received();
    outlet_.drops.count("stood still: what waited in the line is too old");
    const auto until = std::chrono::steady_clock::now() + kDrain;
    uint8_t old[4096];
    while (std::chrono::steady_clock::now() < until) {
      stream_.read(old, std::chrono::milliseconds(20));
    }
    driver_->on_line_emptied();
    last_step_ = std::chrono::steady_clock::now();
  }

  void watch(const LaserScan& scan) {
    alike_ = scan.ranges_m == last_ranges_m_ ? alike_ + 1 : 0;
    if (alike_ == 0) last_ranges_m_ = scan.ranges_m;
  }

  void publish(ArrivedScan& arrived) {
    outlet_.drops.count_received();
    watch(arrived.scan);
    arrived.scan.channel = outlet_.laser.place.channel;
    if (outlet_.laser.raw) {
      outlet_.bus.publish(arrived.scan.channel, to_raw_message(arrived.scan));
    } else {
      // planar_lidar_t has no place for the beams' own times: its readers spread SENSOR_INFO's scan
      // duration over them.
      arrived.scan.time_offsets_s.clear();
      outlet_.bus.publish(arrived.scan.channel, to_message(arrived.scan));
    }
    outlet_.add_latency((wall_now() - arrived.arrival).seconds());
  }

  void count_drops() {
    for (const auto& [cause, count] : driver_->counts().drops) {
      for (int64_t& told = told_[cause]; told < count; ++told) {
        outlet_.drops.count_received();
        outlet_.drops.count(cause);
      }
    }
  }

  ByteStream& stream_;
  std::unique_ptr<LaserDriver> driver_;
  Outlet outlet_;
  std::map<std::string, int64_t> told_;
  std::vector<float> last_ranges_m_;
  int alike_ = 0;
  std::chrono::steady_clock::time_point last_step_ = std::chrono::steady_clock::now();
};

}  // namespace

SensorInfo sensor_info(const LaserPlace& place, const LaserSight& sight, Utime now) {
  require(place.mount == "robot" || place.mount == "pantilt",
          "mount is 'robot' or 'pantilt', not '" + place.mount + "'");
  require(place.position_m.size() == 3 && place.roll_pitch_yaw_deg.size() == 3,
          "position_m and roll_pitch_yaw_deg have three numbers each");
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  SensorInfo info;
  info.utime = now;
  info.channel = place.channel;
  info.mount = place.mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
  info.parent_from_sensor =
      make_pose3({place.position_m[0], place.position_m[1], place.position_m[2]},
                 place.roll_pitch_yaw_deg[0] * kRadPerDeg, place.roll_pitch_yaw_deg[1] * kRadPerDeg,
                 place.roll_pitch_yaw_deg[2] * kRadPerDeg);
  info.scan_duration_s = sight.scan_duration_s;
  info.range_min_m = sight.range_min_m;
  // As the scans' floats say it: a no return must not lie a rounding below the limit.
  info.range_max_m = static_cast<double>(static_cast<float>(sight.range_max_m));
  info.range_sigma_m = sight.range_sigma_m;
  return info;
}

void run_laser(process::Bus& bus, const LaserProcess& laser, const std::function<bool()>& stop) {
  // Options that make no sense are refused before any device is opened.
  sensor_info(laser.place, {}, wall_now());
  NoLine no_line;
  laser.start(no_line);
  process::DropCounter drops([](const std::string& line) { spdlog::warn("{}", line); });
  std::optional<LaserSight> sight;
  DriverLoopOptions options;
  options.process = laser.process;
  options.address = laser.address;
  options.line = laser.line;
  options.open = laser.open;
  options.every_second = [&] {
    if (!sight) return;
    bus.publish(channels::kSensorInfo, to_message(sensor_info(laser.place, *sight, wall_now())));
  };
  DriverLoop* running = nullptr;
  DriverLoop loop(bus, drops, options, [&](ByteStream& stream) {
    return std::make_unique<LaserSession>(
        stream, laser.start(stream),
        LaserSession::Outlet{bus, drops, laser,
                             [&running](double seconds) { running->add_latency(seconds); }, sight});
  });
  running = &loop;
  loop.run(stop);
  spdlog::info("{}", drops.summary());
}

int run_laser_until_stopped(const process::CommonArguments& arguments, const LaserProcess& laser) {
  process::start_logging(laser.process, arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  spdlog::info("{} on {} of {}", laser.address, laser.place.channel,
               process::effective_lcm_url(arguments.lcm_url));
  run_laser(bus, laser, process::stop_requested);
  return 0;
}

}  // namespace marco::drivers
