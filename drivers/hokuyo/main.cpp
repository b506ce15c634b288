#include "drivers/hokuyo/driver.hpp"
#include "drivers/process/laser_process.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace {

struct Options {
  std::string device = "/dev/ttyACM0";  ///< a path or tcp:HOST:10940
  marco::drivers::LaserPlace place;
  marco::drivers::hokuyo::HokuyoOptions hokuyo;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("place", place);
    v("hokuyo", hokuyo);
  }
};

marco::drivers::LaserProcess process_of(const Options& options) {
  using namespace marco::drivers;  // NOLINT(google-build-using-namespace)
  return {"marco-hokuyo",
          options.device,
          {},  // the driver sets it
          options.place,
          false,
          [hokuyo = options.hokuyo](ByteStream& stream) {
            return std::make_unique<hokuyo::HokuyoDriver>(stream, hokuyo, wall_now);
          },
          {}};
}

}  // namespace

int main(int argc, char** argv) {
  return marco::drivers::laser_main<Options>(
      argc, argv, "marco-hokuyo", "Driver of Hokuyo lasers that speak SCIP 2.0", process_of);
}
