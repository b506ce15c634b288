// Your own driver: publishes a laser's scans on LIDAR, and its mount once a second. Here the laser
// is simulated: it stands in a round room of 3 m.   my_laser [SECONDS]
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <thread>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace {

marco::Utime now() {
  using namespace std::chrono;
  return marco::Utime::from_us(
      duration_cast<microseconds>(system_clock::now().time_since_epoch()).count());
}

}  // namespace

int main(int argc, char** argv) {
  marco::process::LcmBus bus("");  // LCM_DEFAULT_URL, or this host alone
  marco::SensorInfo place;         // at the origin of the robot, looking ahead
  place.parent_from_sensor.translation() << 0.10, 0.0, 0.25;
  place.range_max_m = 12.0;
  const int scans = argc > 1 ? 10 * std::atoi(argv[1]) : 1000000;
  for (int i = 0; i < scans; ++i) {
    if (i % 10 == 0) {
      place.utime = now();
      bus.publish(marco::channels::kSensorInfo, to_message(place));
    }
    marco::LaserScan scan;
    scan.utime = now();
    scan.ranges_m.assign(360, 3.0F);  // what your device measured; 0 or infinite: no return
    scan.first_bearing_rad = -std::numbers::pi;
    scan.bearing_step_rad = 2.0 * std::numbers::pi / 360.0;
    bus.publish(marco::channels::kLidar, to_message(scan));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}
