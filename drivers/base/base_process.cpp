#include "drivers/base/base_process.hpp"

#include <spdlog/spdlog.h>

#include <array>
#include <thread>

#include "common/order_age.hpp"
#include "drivers/base/stop_latch.hpp"
#include "drivers/process/driver_loop.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace marco::drivers {
namespace {

constexpr std::chrono::milliseconds kReadFor{4};

/// Messages in and out; lives as long as the process.
class BaseAdapter {
 public:
  BaseAdapter(process::LcmBus& bus, process::DropCounter& drops, BaseDriver& driver)
      : bus_(bus), driver_(driver) {
    bus.subscribe<base_command_t>(
        channels::kBaseCommand, drops,
        [this](const base_command_t& message, const process::RawMessage&) {
          driver_.command(from_message(message), wall_now());
        });
    bus.subscribe<emergency_stop_t>(
        channels::kEmergencyStop, drops,
        [this](const emergency_stop_t& message, const process::RawMessage&) {
          driver_.emergency_stop(from_message(message), wall_now());
        });
    bus.subscribe<pantilt_command_t>(
        channels::kPanTiltCommand, drops,
        [this](const pantilt_command_t& message, const process::RawMessage&) {
          const PanTiltCommand command = from_message(message);
          require_fresh(command, wall_now());
          driver_.look(command, wall_now());
        });
    bus.subscribe_raw("SENSOR_INFO|PANTILT_STATE|" + std::string(channels::kLidarPattern),
                      [this, &drops](const process::RawMessage& raw) { on_sample(raw, drops); });
  }

  void handle_messages() {
    constexpr int kAtMost = 50;  // a flood of messages must not keep the device waiting
    for (int i = 0; i < kAtMost && bus_.handle_once(0); ++i) {
    }
  }

  void publish() {
    const BaseOutput output = driver_.take_output();
    for (const OdometrySample& sample : output.odometry) {
      bus_.publish(channels::kOdometry, to_message(sample));
    }
    for (const BaseStatus& status : output.status) {
      bus_.publish(channels::kBaseStatus, to_message(status));
    }
    for (const SonarRing& ring : output.sonar) bus_.publish(channels::kSonar, to_message(ring));
    for (const PanTiltState& head : output.head) {
      bus_.publish(channels::kPanTiltState, to_message(head));
    }
    for (const ImuSample& sample : output.imu) bus_.publish(channels::kImu, to_message(sample));
  }

  BaseDriver& driver() { return driver_; }

 private:
  void on_sample(const process::RawMessage& raw, process::DropCounter& drops) {
    drops.count_received();
    try {
      const auto sample = decode_sample(std::string(raw.channel), raw.bytes);
      if (!sample) return drops.count("undecodable");
      ObstacleGuard& guard = driver_.guard();
      if (const auto* info = std::get_if<SensorInfo>(&*sample)) guard.on_sensor_info(*info);
      if (const auto* state = std::get_if<PanTiltState>(&*sample)) guard.on_pantilt(*state);
      if (const auto* scan = std::get_if<LaserScan>(&*sample)) {
        guard.on_scan(*scan, driver_.odom_from_robot(), wall_now());
      }
    } catch (const std::invalid_argument& bad_message) {
      drops.count(bad_message.what());
    }
  }

  process::LcmBus& bus_;
  BaseDriver& driver_;
};

class BaseSession : public DeviceSession {
 public:
  BaseSession(BaseAdapter& adapter, ByteStream& stream) : adapter_(adapter), stream_(stream) {
    adapter_.handle_messages();  // refuses the orders from before the device was there
    adapter_.driver().on_connection(true, wall_now());
  }
  /// Also when something went wrong: the motors must not stay on.
  ~BaseSession() override {
    try {
      if (!stopped_) leave_motors_off();
    } catch (const std::exception&) {
      // The line is gone; only the board's own watchdog or a person can stop it now.
    }
    adapter_.driver().on_connection(false, wall_now());
  }
  BaseSession(const BaseSession&) = delete;
  BaseSession& operator=(const BaseSession&) = delete;

  void step() override {
    std::array<uint8_t, 4096> buffer;
    const std::size_t count = stream_.read(buffer, kReadFor);
    if (count > 0) adapter_.driver().receive({buffer.data(), count}, wall_now());
    adapter_.handle_messages();
    if (const auto baud = adapter_.driver().take_line_speed()) {
      stream_.set_line({*baud, Parity::none});
    }
    std::vector<uint8_t> out;
    adapter_.driver().advance(wall_now(), out);
    if (!out.empty()) stream_.write(out);
    adapter_.publish();
    answered_ = answered_ || answers();
  }

  /// Nothing before it answered: perhaps the line has another speed.
  std::vector<uint8_t> stop_bytes() const override {
    return answered_ ? adapter_.driver().stop_bytes() : std::vector<uint8_t>{};
  }

  void on_hang(double seconds) override { adapter_.driver().on_hang(seconds, wall_now()); }

  std::string state() const override {
    std::string text = adapter_.driver().state();
    if (const int64_t bad = adapter_.driver().bad_input(); bad > 0) {
      text += ", " + std::to_string(bad) + " bad lines";
    }
    return text;
  }

  bool answers() const override {
    return adapter_.driver().status().link != BaseStatus::Link::down;
  }

  void stop() override {
    stopped_ = true;
    leave_motors_off();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the bytes have left
  }

 private:
  void leave_motors_off() {
    std::vector<uint8_t> out;
    adapter_.driver().shut_down(out);
    stream_.write(out);
  }

  BaseAdapter& adapter_;
  ByteStream& stream_;
  bool stopped_ = false;
  bool answered_ = false;
};

}  // namespace

int run_base_until_stopped(const process::CommonArguments& arguments, BaseProcess base) {
  process::start_logging(base.process, arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  BaseAdapter adapter(bus, drops, *base.driver);
  const std::string name = base.driver->status().base;
  const auto stay_stopped = [&base, latch = StopLatch(name, arguments.lcm_url)] {
    const auto stop = latch.load();
    if (stop) base.driver->emergency_stop(*stop, wall_now());
    return stop;
  };
  if (const auto stop = stay_stopped()) {
    spdlog::warn("still stopped by {}: marco stop --release lets it move", stop->sender);
  }
  DriverLoopOptions options;
  options.process = base.process;
  options.address = base.address;
  options.line = base.line;
  options.guardian = {{"--base", name, "--lcm-url", process::effective_lcm_url(arguments.lcm_url)}};
  options.every_second = [&adapter] {
    // Without a device this is the only step: it refuses orders at once and keeps publishing the
    // status.
    adapter.handle_messages();
    std::vector<uint8_t> nowhere;
    if (adapter.driver().status().link == BaseStatus::Link::down) {
      adapter.driver().advance(wall_now(), nowhere);
    }
    adapter.publish();
  };
  DriverLoop loop(bus, drops, std::move(options), [&](ByteStream& stream) {
    stay_stopped();  // the last driver's guardian, which has ended now, may have kept it late
    return std::make_unique<BaseSession>(adapter, stream);
  });
  loop.run(process::stop_requested);
  adapter.publish();
  return 0;
}

}  // namespace marco::drivers
