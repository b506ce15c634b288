#include "drivers/base/base_process.hpp"
#include "drivers/textbase/driver.hpp"

namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyACM0";  ///< a path or tcp:HOST:PORT
  textbase::TextBaseOptions base;

  GuardOptions& guard() { return base.guard; }
  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("base", base);
  }
};

BaseProcess process_of(const Options& options) {
  return {"marco-textbase",
          options.device,
          {textbase::kBaud, Parity::none},
          std::make_unique<textbase::TextBase>(options.base)};
}

}  // namespace

int main(int argc, char** argv) {
  return base_main<Options>(argc, argv, "marco-textbase",
                            "Driver of home-made bases that speak Marco's text protocol",
                            process_of);
}
