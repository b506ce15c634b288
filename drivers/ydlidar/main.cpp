#include "drivers/laser/laser_process.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "drivers/ydlidar/driver.hpp"

namespace marco::drivers {
namespace {

void prepare(const ydlidar::YdlidarOptions& options, LaserProcess& laser) {
  laser.line.baud = 128'000;
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<ydlidar::YdlidarDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(argc, argv, "Driver of the YDLIDAR X2, X4 and G4 lasers",
                                    marco::drivers::prepare);
}
