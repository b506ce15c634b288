#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/base/base_driver.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "lcm_tools/process/arguments.hpp"

namespace marco::drivers {

/// A base as a process.
struct BaseProcess {
  std::string process;  ///< "marco-base"
  std::string address;  ///< for open_stream
  LineSettings line;
  std::unique_ptr<BaseDriver> driver;
};

/// BASE_COMMAND and EMERGENCY_STOP in, and PANTILT_COMMAND for a head on the base's own line;
/// ODOMETRY, BASE_STATUS, SONAR, PROCESS_STATUS out, that head's PANTILT_STATE and a gyro's IMU;
/// LIDAR, SENSOR_INFO and PANTILT_STATE go to the guard. Until SIGINT or SIGTERM, which leave the
/// motors off.
/// @returns the exit code. @throws as DriverLoop::run.
int run_base_until_stopped(const process::CommonArguments& arguments, BaseProcess base);

/// The body of a base's main. `Options` has `device`, `guard()` and `visit`.
template <class Options>
int base_main(int argc,
              const char* const* argv,
              const std::string& name,
              const std::string& description,
              BaseProcess (*process_of)(const Options&)) {
  return driver_main<Options>(
      argc, argv,
      {name, description,
       [process_of](const process::CommonArguments& arguments, const Options& options) {
         return run_base_until_stopped(arguments, process_of(options));
       },
       DriverSwitch<Options>{"--no-guard", "drive into obstacles if told to",
                             [](Options& options) { options.guard().enabled = false; }}});
}

}  // namespace marco::drivers
