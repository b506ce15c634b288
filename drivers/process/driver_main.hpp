#pragma once

#include <functional>
#include <optional>
#include <string>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"

namespace marco::drivers {

/// A switch of one driver's command line; overrides its config.
template <class Options>
struct DriverSwitch {
  std::string name;  ///< "--no-guard"
  std::string help;
  std::function<void(Options&)> apply;
};

/// What one driver adds to driver_main.
template <class Options>
struct DriverProgram {
  std::string name;  ///< "marco-base"
  std::string description;
  /// Drives the device until a stop signal, with the options as given. @returns the exit code
  std::function<int(const process::CommonArguments&, const Options&)> run;
  std::optional<DriverSwitch<Options>> extra = std::nullopt;
};

/// The body of a driver's main: --config, --device, --print-config and the arguments all processes
/// have. Options: a struct with `visit` and a member `device`.
/// @returns the exit code, that of `driver.run` if it came to that
template <class Options>
int driver_main(int argc, const char* const* argv, const DriverProgram<Options>& driver) {
  return process::run_main(driver.name, [&] {
    process::CommandLine app(driver.description);
    process::CommonArguments arguments;
    process::add_common_arguments(app, arguments);
    std::string device;
    bool switched = false;
    if (driver.extra) app.add_flag(driver.extra->name, switched, driver.extra->help);
    app.add_option("--device", device,
                   "overrides the config: a path; for a serial line also tcp:HOST:PORT")
        .check([](const std::string& given) {
          return given.empty() ? "no device: give a path, or tcp:HOST:PORT" : "";
        });
    if (const auto code = app.parse(argc, argv)) return *code;
    auto options = process::load_options<Options>(arguments.config_path);
    if (!device.empty()) options.device = device;
    if (switched) driver.extra->apply(options);
    if (process::prints_config(arguments, options)) return 0;
    return driver.run(arguments, options);
  });
}

}  // namespace marco::drivers
