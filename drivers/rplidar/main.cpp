#include "drivers/process/laser_process.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace {

marco::drivers::LaserPlace raw_place() {
  marco::drivers::LaserPlace place;
  place.channel = "LIDAR_RAW";
  return place;
}

struct Options {
  std::string device = "/dev/ttyUSB0";  ///< a path or tcp:HOST:PORT
  marco::drivers::LaserPlace place = raw_place();
  marco::drivers::rplidar::RplidarOptions rplidar;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("place", place);
    v("rplidar", rplidar);
  }
};

marco::drivers::LaserProcess process_of(const Options& options) {
  using namespace marco::drivers;  // NOLINT(google-build-using-namespace)
  return {"marco-rplidar",
          options.device,
          {options.rplidar.baud, Parity::none},
          options.place,
          true,
          [rplidar = options.rplidar](ByteStream& stream) {
            return std::make_unique<rplidar::RplidarDriver>(stream, rplidar, wall_now);
          },
          {}};
}

}  // namespace

int main(int argc, char** argv) {
  return marco::drivers::laser_main<Options>(
      argc, argv, "marco-rplidar", "Driver of the Slamtec RPLIDAR A1 and A2 lasers", process_of);
}
