#include "drivers/leuze/driver.hpp"
#include "drivers/process/laser_process.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace {

struct Options {
  std::string device = "/dev/ttyUSB0";  ///< a path or tcp:HOST:PORT (native 9008, service 8000)
  marco::drivers::LaserPlace place;
  marco::drivers::leuze::LeuzeOptions leuze;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("place", place);
    v("leuze", leuze);
  }
};

marco::drivers::LaserProcess process_of(const Options& options) {
  using namespace marco::drivers;  // NOLINT(google-build-using-namespace)
  LaserProcess process;
  process.process = "marco-leuze";
  process.address = options.device;
  process.place = options.place;
  if (options.leuze.service) {
    process.open = [device = options.device] {
      return std::make_unique<leuze::ConnectionPerRequest>(
          [device] { return open_stream(device, {}); });
    };
  }
  process.start = [leuze = options.leuze](ByteStream& stream) -> std::unique_ptr<LaserDriver> {
    if (!leuze.service) return std::make_unique<leuze::LeuzeDriver>(stream, leuze, wall_now);
    return std::make_unique<leuze::LeuzeServiceDriver>(stream, leuze, wall_now);
  };
  return process;
}

}  // namespace

int main(int argc, char** argv) {
  return marco::drivers::laser_main<Options>(
      argc, argv, "marco-leuze",
      "Driver of the Leuze Rotoscan RS4: its own telegrams, or thesis A's socket service",
      process_of);
}
