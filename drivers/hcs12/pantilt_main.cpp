#include <array>
#include <thread>

#include "common/order_age.hpp"
#include "common/pose3.hpp"
#include "drivers/hcs12/pantilt_driver.hpp"
#include "drivers/process/driver_loop.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace {

using namespace marco;           // NOLINT(google-build-using-namespace): a main has no other names
using namespace marco::drivers;  // NOLINT(google-build-using-namespace)

struct Options {
  std::string device = "/dev/ttyUSB2";                    ///< a path or tcp:HOST:PORT
  std::vector<double> position_m{0.10, 0.0, 0.60};        ///< of the pan axis's base on the robot
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};  ///< of the same
  std::vector<double> tilt_axis_m{0.0, 0.0, 0.0};         ///< in the panned frame
  hcs12::PanTiltOptions pantilt;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("position_m", position_m);
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("tilt_axis_m", tilt_axis_m);
    v("pantilt", pantilt);
  }

  SensorInfo info() const {
    require(position_m.size() == 3 && roll_pitch_yaw_deg.size() == 3 && tilt_axis_m.size() == 3,
            "position_m, roll_pitch_yaw_deg, tilt_axis_m: expected three numbers each");
    SensorInfo info;
    info.channel = channels::kPanTiltState;
    info.parent_from_sensor =
        make_pose3(Eigen::Vector3d(position_m.data()), deg_to_rad(roll_pitch_yaw_deg[0]),
                   deg_to_rad(roll_pitch_yaw_deg[1]), deg_to_rad(roll_pitch_yaw_deg[2]));
    info.tilt_axis_m = Eigen::Vector3d(tilt_axis_m.data());
    return info;
  }
};

class PanTiltSession : public DeviceSession {
 public:
  PanTiltSession(hcs12::PanTiltDriver& driver, process::LcmBus& bus, ByteStream& stream)
      : driver_(driver), bus_(bus), stream_(stream) {
    while (bus_.handle_once(0)) {
    }
    driver_.on_connection(true, wall_now());
  }
  ~PanTiltSession() override { driver_.on_connection(false, wall_now()); }
  PanTiltSession(const PanTiltSession&) = delete;
  PanTiltSession& operator=(const PanTiltSession&) = delete;

  void step() override {
    std::array<uint8_t, 1024> buffer;
    const std::size_t count = stream_.read(buffer, std::chrono::milliseconds(4));
    if (count > 0) driver_.receive({buffer.data(), count}, wall_now());
    while (bus_.handle_once(0)) {
    }
    std::vector<uint8_t> out;
    driver_.advance(wall_now(), out);
    if (!out.empty()) stream_.write(out);
    for (const PanTiltState& state : driver_.take_states()) {
      bus_.publish(channels::kPanTiltState, to_message(state));
    }
  }
  std::vector<uint8_t> stop_bytes() const override {
    std::vector<uint8_t> bytes;
    if (driver_.moving()) driver_.shut_down(bytes);
    return bytes;
  }
  void on_hang(double /*seconds*/) override {
    driver_.command({wall_now(), PanTiltCommand::Kind::stop}, wall_now());
  }
  std::string state() const override { return driver_.state(); }
  bool answers() const override { return driver_.link() != hcs12::PanTiltDriver::Link::down; }
  void stop() override {
    std::vector<uint8_t> out;
    driver_.shut_down(out);
    stream_.write(out);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the bytes have left
  }

 private:
  hcs12::PanTiltDriver& driver_;
  process::LcmBus& bus_;
  ByteStream& stream_;
};

int run(const process::CommonArguments& arguments, const Options& options) {
  process::start_logging("marco-pantilt", arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  process::DropCounter drops;
  hcs12::PanTiltDriver driver(options.pantilt);
  bus.subscribe<pantilt_command_t>(
      channels::kPanTiltCommand, drops,
      [&driver](const pantilt_command_t& message, const process::RawMessage&) {
        const PanTiltCommand command = from_message(message);
        require_fresh(command, wall_now());
        driver.command(command, wall_now());
      });
  SensorInfo info = options.info();
  DriverLoopOptions loop_options;
  loop_options.process = "marco-pantilt";
  loop_options.address = options.device;
  loop_options.line = {hcs12::kBaud, Parity::none};
  loop_options.guardian.emplace();
  loop_options.every_second = [&bus, &info] {
    info.utime = wall_now();
    bus.publish(channels::kSensorInfo, to_message(info));
  };
  DriverLoop loop(bus, drops, std::move(loop_options), [&](ByteStream& stream) {
    return std::make_unique<PanTiltSession>(driver, bus, stream);
  });
  loop.run(process::stop_requested);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return driver_main<Options>(argc, argv,
                              {"marco-pantilt", "Driver of the HCS12 pan-tilt of thesis B", run});
}
