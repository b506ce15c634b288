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

/// The config of a base's process.
template <class Base>
struct BaseOptions {
  std::string device = Base::kDevice;  ///< a path or tcp:HOST:PORT
  typename Base::Options base;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

/// The body of a base's main. `Base` is a BaseDriver with its `Options`, the default `kDevice`, and
/// `kLineSpeed`, the baud rate to begin with; its line has no parity.
template <class Base>
int base_main(int argc,
              const char* const* argv,
              const std::string& name,
              const std::string& description) {
  using Options = BaseOptions<Base>;
  return driver_main<Options>(
      argc, argv,
      {name, description,
       [&name](const process::CommonArguments& arguments, const Options& options) {
         return run_base_until_stopped(arguments, {name,
                                                   options.device,
                                                   {Base::kLineSpeed, Parity::none},
                                                   std::make_unique<Base>(options.base)});
       },
       DriverSwitch<Options>{"--no-guard", "drive into obstacles when ordered to",
                             [](Options& options) { options.base.guard.enabled = false; }}});
}

}  // namespace marco::drivers
