#include "drivers/bno055/driver.hpp"
#include "drivers/imu/imu_process.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/serial0";
  drivers::bno055::Bno055Options bno055;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("bno055", bno055);
  }
};

int run(const process::CommonArguments& arguments, const Options& options) {
  return drivers::imu::run_imu<drivers::bno055::Bno055Driver>(
      arguments, "marco-bno055", options.device, {drivers::bno055::kBaud, drivers::Parity::none},
      options.bno055);
}

}  // namespace

int main(int argc, char** argv) {
  return drivers::driver_main<Options>(
      argc, argv, {"marco-bno055", "Driver of the Bosch BNO055 IMU by UART", run});
}
