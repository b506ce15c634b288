#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "drivers/laser/laser_driver.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::process {
class Bus;
}

namespace marco::drivers {

/// Where a laser sits and on which channel it speaks.
struct LaserPlace {
  std::string channel = "LIDAR";                          ///< LIDAR_<NAME> with several lasers
  std::string mount = "robot";                            ///< or "pantilt": its tilted plate
  std::vector<double> position_m{0.0, 0.0, 0.0};          ///< of the sensor in its parent
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};  ///< roll 180: mounted upside down

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("mount", mount);
    v("position_m", position_m);
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
  }
};

/// @throws std::invalid_argument for a mount or lengths that make no sense.
SensorInfo sensor_info(const LaserPlace& place, const LaserSight& sight, Utime now);

/// A laser as a process.
struct LaserProcess {
  std::string process;  ///< "marco-sick"
  std::string address;  ///< for open_stream
  LineSettings line;
  LaserPlace place;
  bool raw = false;  ///< irregular bearings: lidar_raw_t, on LIDAR_RAW
  std::function<std::unique_ptr<LaserDriver>(ByteStream&)> start;
  std::function<std::unique_ptr<ByteStream>()> open;  ///< empty: open_stream(address, line)
};

/// Publishes the laser's scans, SENSOR_INFO and PROCESS_STATUS until `stop` says so.
/// @throws as DriverLoop::run.
void run_laser(process::Bus& bus, const LaserProcess& laser, const std::function<bool()>& stop);

/// As above on the LCM network until SIGINT or SIGTERM. @returns the exit code.
int run_laser_until_stopped(const process::CommonArguments& arguments, const LaserProcess& laser);

/// The body of a laser's main. Options: a struct with `visit`.
/// @param process_of  makes the process from its options.
template <class Options>
int laser_main(int argc,
               const char* const* argv,
               const std::string& name,
               const std::string& description,
               LaserProcess (*process_of)(const Options&)) {
  return driver_main<Options>(
      argc, argv, name, description,
      [&](const process::CommonArguments& arguments, const Options& options) {
        return run_laser_until_stopped(arguments, process_of(options));
      });
}

}  // namespace marco::drivers
