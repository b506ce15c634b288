#include <array>

#include "drivers/imu/driver.hpp"
#include "drivers/process/driver_loop.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyUSB3";
  drivers::imu::ImuOptions imu;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("imu", imu);
  }
};

class ImuSession : public drivers::DeviceSession {
 public:
  ImuSession(const drivers::imu::ImuOptions& options,
             process::LcmBus& bus,
             drivers::ByteStream& stream)
      : driver_(options), bus_(bus), stream_(stream) {
    driver_.on_connection(true, drivers::wall_now());
  }
  void step() override {
    std::array<uint8_t, 1024> buffer;
    const std::size_t count = stream_.read(buffer, std::chrono::milliseconds(20));
    if (count > 0) driver_.receive({buffer.data(), count}, drivers::wall_now());
    std::vector<uint8_t> out;
    driver_.advance(drivers::wall_now(), out);
    if (!out.empty()) stream_.write(out);
    for (const ImuSample& sample : driver_.take_samples()) {
      bus_.publish(channels::kImu, to_message(sample));
    }
  }
  std::string state() const override { return driver_.state(); }
  bool answers() const override { return driver_.alive(); }

 private:
  drivers::imu::ImuDriver driver_;
  process::LcmBus& bus_;
  drivers::ByteStream& stream_;
};

int run(const process::CommonArguments& arguments, const Options& options) {
  process::start_logging("marco-imu", arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  const drivers::imu::ImuDriver checked(options.imu);  // throws before the device is opened
  drivers::DriverLoopOptions loop_options;
  loop_options.process = "marco-imu";
  loop_options.address = options.device;
  loop_options.line = {options.imu.baud, drivers::Parity::none};
  drivers::DriverLoop loop(bus, drops, std::move(loop_options), [&](drivers::ByteStream& stream) {
    return std::make_unique<ImuSession>(options.imu, bus, stream);
  });
  loop.run(process::stop_requested);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return drivers::driver_main<Options>(
      argc, argv, {"marco-imu", "Driver of a serial WitMotion IMU (WT61, WT901, JY901)", run});
}
