#include "drivers/base/base_process.hpp"
#include "drivers/create/driver.hpp"

namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyUSB0";  ///< a path or tcp:HOST:PORT
  create::CreateOptions base;

  GuardOptions& guard() { return base.guard; }
  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

BaseProcess process_of(const Options& options) {
  return {"marco-create",
          options.device,
          {create::kBaud, Parity::none},  // at first
          std::make_unique<create::CreateBase>(options.base)};
}

}  // namespace

int main(int argc, char** argv) {
  return base_main<Options>(argc, argv, "marco-create",
                            "Driver of the iRobot Create 2 and Roomba (Open Interface)",
                            process_of);
}
