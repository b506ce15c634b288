#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/process/driver_loop.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco::drivers::imu {

/// Steps the driver of an inertial sensor, and publishes its samples on IMU.
template <class Driver>
class ImuSession final : public DeviceSession {
 public:
  /// All outlive the session.
  ImuSession(Driver driver, process::LcmBus& bus, ByteStream& stream)
      : driver_(std::move(driver)), bus_(bus), stream_(stream) {
    driver_.on_connection(true, wall_now());
  }
  void step() override {
    std::array<uint8_t, 1024> buffer;
    const std::size_t count = stream_.read(buffer, kStep);
    if (count > 0) driver_.receive({buffer.data(), count}, wall_now());
    std::vector<uint8_t> out;
    driver_.advance(wall_now(), out);
    if (!out.empty()) stream_.write(out);
    for (const ImuSample& sample : driver_.take_samples()) {
      bus_.publish(channels::kImu, to_message(sample));
    }
  }
  std::string state() const override { return driver_.state(); }
  bool answers() const override { return driver_.alive(); }

 private:
  static constexpr std::chrono::microseconds kStep = Driver::kStep;
  Driver driver_;
  process::LcmBus& bus_;
  ByteStream& stream_;
};

/// The main of an inertial sensor's process, at `line`, after its options were checked.
template <class Driver, class Options>
int run_imu(const process::CommonArguments& arguments,
            const std::string& name,
            const std::string& device,
            const LineSettings& line,
            const Options& options) {
  process::start_logging(name, arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  bus.keep_going_without_network();
  process::DropCounter drops;
  const Driver checked(options);  // throws before the device is opened
  DriverLoopOptions loop_options;
  loop_options.process = name;
  loop_options.address = device;
  loop_options.line = line;
  DriverLoop loop(bus, drops, std::move(loop_options), [&](ByteStream& stream) {
    return std::make_unique<ImuSession<Driver>>(Driver(options), bus, stream);
  });
  loop.run(process::stop_requested);
  return 0;
}

}  // namespace marco::drivers::imu
