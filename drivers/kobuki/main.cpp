#include "drivers/base/base_process.hpp"
#include "drivers/kobuki/driver.hpp"

namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyUSB0";  ///< a path or tcp:HOST:PORT
  kobuki::KobukiOptions base;

  GuardOptions& guard() { return base.guard; }
  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

BaseProcess process_of(const Options& options) {
  return {"marco-kobuki",
          options.device,
          {kobuki::kBaud, Parity::none},
          std::make_unique<kobuki::KobukiBase>(options.base)};
}

}  // namespace

int main(int argc, char** argv) {
  return base_main<Options>(argc, argv, "marco-kobuki",
                            "Driver of Yujin Robot's Kobuki (TurtleBot 2), with its gyro",
                            process_of);
}
