#include "drivers/base/base_process.hpp"
#include "drivers/p2os/driver.hpp"

namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyS0";  ///< a path or tcp:HOST:8101
  p2os::P2osOptions base;

  GuardOptions& guard() { return base.guard; }
  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

BaseProcess process_of(const Options& options) {
  return {"marco-p2os",
          options.device,
          {p2os::kBaud, Parity::none},
          std::make_unique<p2os::P2osBase>(options.base)};
}

}  // namespace

int main(int argc, char** argv) {
  return base_main<Options>(argc, argv, "marco-p2os",
                            "Driver of ActivMedia Pioneer robots (P2OS, ARCOS)", process_of);
}
