#include "drivers/cola/driver.hpp"
#include "drivers/laser/laser_process.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers {
namespace {

void prepare(const cola::ColaOptions& options, LaserProcess& laser) {
  laser.start = [options](ByteStream& stream) {
    return std::make_unique<cola::ColaDriver>(stream, options, wall_now);
  };
}

}  // namespace
}  // namespace marco::drivers

int main(int argc, char** argv) {
  return marco::drivers::laser_main(argc, argv,
                                    "Driver of the SICK TiM5xx and LMS1xx lasers (CoLa A over TCP)",
                                    marco::drivers::prepare);
}
