#include "drivers/laser/laser_process.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const sick::SickOptions& options, LaserProcess& laser) {
  laser.line.baud = options.baud;
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<sick::SickDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(argc, argv,
                                    "Driver of the SICK LMS 200, 211, 220, 221, 291 and 209 lasers",
                                    marco::drivers::prepare);
}
