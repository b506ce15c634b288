#include "drivers/process/laser_process.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace {

struct Options {
  std::string device = "/dev/ttyUSB0";  ///< a path or tcp:HOST:PORT
  marco::drivers::LaserPlace place;
  marco::drivers::sick::SickOptions sick;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("place", place);
    v("sick", sick);
  }
};

marco::drivers::LaserProcess process_of(const Options& options) {
  using namespace marco::drivers;  // NOLINT(google-build-using-namespace)
  return {"marco-sick",
          options.device,
          {options.sick.baud, Parity::none},
          options.place,
          false,
          [sick = options.sick](ByteStream& stream) {
            return std::make_unique<sick::SickDriver>(stream, sick, wall_now);
          },
          {}};
}

}  // namespace

int main(int argc, char** argv) {
  return marco::drivers::laser_main<Options>(
      argc, argv, "marco-sick", "Driver of the SICK LMS 200, 211, 220, 221, 291 and 209 lasers",
      process_of);
}
