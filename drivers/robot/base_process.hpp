#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "drivers/robot/base_driver.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers {

/// A base as a process.
struct BaseProcess {
  std::string process;  ///< "marco-base"
  std::string address;  ///< for open_stream
  LineSettings line;
  std::unique_ptr<BaseDriver> driver;
};

/// BASE_COMMAND in, and PANTILT_COMMAND for a head on the base's own line; ODOMETRY, BASE_STATUS,
/// SONAR, PROCESS_STATUS out, and that head's PANTILT_STATE; LIDAR, SENSOR_INFO and
/// PANTILT_STATE go to the guard. Until SIGINT or SIGTERM, which leave the motors off.
/// @returns the exit code. @throws as DriverLoop::run.
int run_base_until_stopped(const process::CommonArguments& arguments, BaseProcess base);

/// The body of a base's main. `Options` has `device`, `guard()` and `visit`.
template <class Options>
int base_main(int argc,
              const char* const* argv,
              const std::string& name,
              const std::string& description,
              BaseProcess (*process_of)(const Options&)) {
  return process::run_main(name, [&] {
    CLI::App app(description);
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    std::string device;
    bool no_guard = false;
    app.add_option("--device", device, "over the config's: a path or tcp:HOST:PORT");
    app.add_flag("--no-guard", no_guard, "drive into obstacles if told to");
    if (const auto code = process::parse_arguments(app, argc, argv)) return *code;
    auto options = process::load_options<Options>(arguments.config_path);
    if (!device.empty()) options.device = device;
    if (no_guard) options.guard().enabled = false;
    if (arguments.print_config) {
      std::fputs(process::print_options(options).c_str(), stdout);
      return 0;
    }
    return run_base_until_stopped(arguments, process_of(options));
  });
}

}  // namespace marco::drivers
