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

/// Where a laser is mounted and which channels carry its scans.
struct LaserPlace {
  /// LIDAR, or LIDAR_<NAME> with several lasers: planar_lidar_t. The same scans with the time of
  /// every beam are on LIDAR_RAW or LIDAR_RAW_<NAME>.
  std::string channel = "LIDAR";
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

/// SENSOR_INFO of the laser's planar channel. A place that names the raw channel means the same
/// laser. @throws std::invalid_argument for an unknown mount or a wrong number of coordinates.
SensorInfo sensor_info(const LaserPlace& place, const LaserProperties& properties, Utime now);

/// A laser as a process.
struct LaserProcess {
  std::string process;  ///< "marco-sick"
  std::string address;  ///< for open_stream
  LaserPlace place;
  LineSettings line;
  std::function<std::unique_ptr<LaserDriver>(ByteStream&)> start;
  std::function<std::unique_ptr<ByteStream>()> open;  ///< empty: open_stream(address, line)
};

/// Publishes the laser's scans, SENSOR_INFO and PROCESS_STATUS until `stop` returns true.
/// @throws as DriverLoop::run.
void run_laser(process::Bus& bus, const LaserProcess& laser, const std::function<bool()>& stop);

/// As above on the LCM network until SIGINT or SIGTERM. @returns the exit code.
int run_laser_until_stopped(const process::CommonArguments& arguments, const LaserProcess& laser);

/// The config of a laser's process. DeviceOptions: a struct with `visit`, kName ("sick") and
/// kDefaultDevice.
template <class DeviceOptions>
struct LaserConfig {
  std::string device = DeviceOptions::kDefaultDevice;  ///< a path or tcp:HOST:PORT
  LaserPlace place;
  DeviceOptions laser;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("place", place);
    v(DeviceOptions::kName, laser);
  }
};

/// The main of every laser's process.
/// @param prepare  sets line, start and open from the options.
template <class DeviceOptions>
int laser_main(int argc,
               const char* const* argv,
               const std::string& description,
               void (*prepare)(const DeviceOptions&, LaserProcess&)) {
  const std::string name = std::string("marco-") + DeviceOptions::kName;
  return driver_main<LaserConfig<DeviceOptions>>(
      argc, argv,
      {name, description,
       [&](const process::CommonArguments& arguments, const LaserConfig<DeviceOptions>& config) {
         LaserProcess laser{name, config.device, config.place, {}, {}, {}};
         prepare(config.laser, laser);
         return run_laser_until_stopped(arguments, laser);
       }});
}

}  // namespace marco::drivers
