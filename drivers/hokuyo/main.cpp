#include "drivers/hokuyo/driver.hpp"
#include "drivers/laser/laser_process.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const hokuyo::HokuyoOptions& options, LaserProcess& laser) {
  // The driver sets the line.
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<hokuyo::HokuyoDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(argc, argv, "Driver of Hokuyo lasers that speak SCIP 2.0",
                                    marco::drivers::prepare);
}
