#include "drivers/laser/laser_process.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const rplidar::RplidarOptions& options, LaserProcess& laser) {
  laser.line.baud = options.baud > 0 ? options.baud : 115'200;
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<rplidar::RplidarDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(argc, argv, "Driver of the Slamtec RPLIDAR A1 and A2 lasers",
                                    marco::drivers::prepare);
}
