#include "drivers/laser/laser_process.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/leuze/service_driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const leuze::LeuzeOptions& options, LaserProcess& laser) {
  if (!options.service) {
    laser.start = [options](ByteStream& stream) {
      return std::make_unique<leuze::LeuzeDriver>(stream, options, wall_now);
    };
    return;
  }
  laser.open = [device = laser.address] {
    return std::make_unique<leuze::ConnectionPerRequest>(
        [device] { return open_stream(device, {}); });
  };
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<leuze::LeuzeServiceDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(
      argc, argv,
      "Driver of the Leuze Rotoscan RS4: its own telegrams, or thesis A's socket service",
      marco::drivers::prepare);
}
