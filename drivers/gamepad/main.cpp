#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "common/process/lcm_bus.hpp"
#include "common/process/status_publisher.hpp"
#include "common/process/stop_signal.hpp"
#include "drivers/gamepad/driver.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace {

struct Options {
  std::string device = "/dev/input/js0";  ///< or a FIFO

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
  }
};

}  // namespace

int main(int argc, char** argv) {
  using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
  return process::run_main("marco-gamepad", [&] {
    CLI::App app("Driver of a gamepad: Linux joystick records from a device or a FIFO");
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    std::string device;
    app.add_option("--device", device, "over the config's");
    if (const auto code = process::parse_arguments(app, argc, argv)) return *code;
    auto options = process::load_options<Options>(arguments.config_path);
    if (!device.empty()) options.device = device;
    if (arguments.print_config) {
      std::fputs(process::print_options(options).c_str(), stdout);
      return 0;
    }
    process::start_logging("marco-gamepad", arguments.log_level);
    process::catch_stop_signals();
    process::LcmBus bus(arguments.lcm_url);
    process::DropCounter drops;
    process::StatusPublisher status(bus, "marco-gamepad", drops);
    drivers::gamepad::GamepadDriver driver(options.device);
    while (!process::stop_requested()) {
      for (const GamepadState& state : driver.step(50, drivers::wall_now())) {
        bus.publish(channels::kGamepad, to_message(state));
      }
      status.tick(driver.open() ? options.device + " is open" : "no gamepad at " + options.device);
    }
    return 0;
  });
}
