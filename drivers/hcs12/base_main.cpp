#include "drivers/base/base_process.hpp"
#include "drivers/hcs12/base_driver.hpp"

namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyUSB1";  ///< a path or tcp:HOST:PORT
  hcs12::Hcs12BaseOptions base;

  GuardOptions& guard() { return base.guard; }
  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

BaseProcess process_of(const Options& options) {
  return {"marco-base",
          options.device,
          {hcs12::kBaud, Parity::none},
          std::make_unique<hcs12::Hcs12Base>(options.base)};
}

}  // namespace

int main(int argc, char** argv) {
  return base_main<Options>(argc, argv, "marco-base", "Driver of the HCS12 base of thesis B",
                            process_of);
}
