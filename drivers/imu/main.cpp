#include "drivers/imu/driver.hpp"
#include "drivers/imu/imu_process.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  std::string device = "/dev/ttyUSB3";
  drivers::imu::ImuOptions imu;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("imu", imu);
  }
};

int run(const process::CommonArguments& arguments, const Options& options) {
  return drivers::imu::run_imu<drivers::imu::ImuDriver>(arguments, "marco-imu", options.device,
                                                        {options.imu.baud, drivers::Parity::none},
                                                        options.imu);
}

}  // namespace

int main(int argc, char** argv) {
  return drivers::driver_main<Options>(
      argc, argv, {"marco-imu", "Driver of a serial WitMotion IMU (WT61, WT901, JY901)", run});
}
