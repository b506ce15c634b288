#include <spdlog/spdlog.h>

#include <utility>

#include "drivers/gamepad/driver.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/input/js0";  ///< or a FIFO

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
  }
};

int run(const process::CommonArguments& arguments, const Options& options) {
  process::start_logging("marco-gamepad", arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  process::StatusPublisher status(bus, "marco-gamepad", drops);
  drivers::gamepad::GamepadDriver driver(options.device);
  std::string told = "nothing yet";
  while (!process::stop_requested()) {
    for (const GamepadState& state : driver.step(50, drivers::wall_now())) {
      bus.publish(channels::kGamepad, to_message(state));
    }
    const std::string open = options.device + " is open";
    status.tick(driver.open() ? open : process::kNoDevice + (": " + driver.trouble()));
    if (std::exchange(told, driver.trouble()) == driver.trouble()) continue;
    if (driver.open()) spdlog::info("{}", open);
    if (!driver.open()) spdlog::warn("{}: {}", process::kNoDevice, driver.trouble());
  }
  // Three times, for a datagram may be lost.
  if (const auto gone = driver.leave(drivers::wall_now())) {
    for (int i = 0; i < 3; ++i) bus.publish(channels::kGamepad, to_message(*gone));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return drivers::driver_main<Options>(
      argc, argv,
      {"marco-gamepad", "Driver of a gamepad: Linux joystick records from a device or a FIFO",
       run});
}
