#include "drivers/laser/laser_process.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const ldlidar::LdlidarOptions& options, LaserProcess& laser) {
  laser.line.baud = 230'400;
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<ldlidar::LdlidarDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(
      argc, argv, "Driver of the LDROBOT LD06, LD19 and STL27L lasers", marco::drivers::prepare);
}
