// Whole drivers, hearing any bytes in simulated time, and emulators that are sent any bytes.
#include <cmath>
#include <memory>

#include "drivers/bno055/driver.hpp"
#include "drivers/cola/driver.hpp"
#include "drivers/create/driver.hpp"
#include "drivers/devices/listening.hpp"
#include "drivers/devices/probe.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "drivers/hcs12/pantilt_driver.hpp"
#include "drivers/hokuyo/driver.hpp"
#include "drivers/imu/driver.hpp"
#include "drivers/kobuki/driver.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/leuze/service_driver.hpp"
#include "drivers/p2os/driver.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/textbase/driver.hpp"
#include "drivers/ydlidar/driver.hpp"
#include "simulator/devices/bno055/emulator.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/hcs12/base_emulator.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/imu/emulator.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "simulator/devices/leuze/emulator.hpp"
#include "simulator/devices/leuze/service_emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

using namespace marco::drivers;  // NOLINT(google-build-using-namespace): a folder of drivers

constexpr Utime kStart = Utime::from_us(1'600'000'000'000'000);
constexpr int kSteps = 200;

/// A line whose other end is the input: a piece a read, each after some of the time waited for.
class FuzzStream final : public ByteStream {
 public:
  explicit FuzzStream(Input input) : input_(input) {}

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override {
    if (input_.empty()) {
      now_ = now_ + Duration::from_us(timeout.count());
      return 0;
    }
    now_ = now_ + Duration::from_us(std::min<int64_t>(timeout.count(), input_.byte() * 400));
    const auto piece = input_.take(std::min<std::size_t>(into.size(), 1U + input_.byte()));
    std::copy(piece.begin(), piece.end(), into.begin());
    return piece.size();
  }
  void write(std::span<const uint8_t>) override { now_ = now_ + Duration::from_us(100); }
  void set_line(const LineSettings&) override {}
  void discard_input() override {}

  Utime now() const { return now_; }

 private:
  Input input_;
  Utime now_ = kStart;
};

template <class Driver, class Options>
void run_laser(Input input, const Options& options) {
  FuzzStream stream(input);
  Driver driver(stream, options, [&stream] { return stream.now(); });
  for (int i = 0; i < kSteps; ++i) {
    const Utime before = stream.now();
    for (const ArrivedScan& arrived : driver.step()) {
      promise(!arrived.scan.ranges_m.empty() && arrived.scan.size() <= 20000, "a scan has beams");
      promise(arrived.scan.time_offsets_s.size() == arrived.scan.size(),
              "a scan's times are one a beam");
    }
    promise(stream.now() - before < Duration::from_seconds(2.0), "a step ends soon");
    promise(!driver.state().empty(), "a driver says how it is");
  }
  driver.properties();
  driver.stop();
}

MARCO_FUZZ(laser_driver) {
  Input input(bytes);
  switch (input.byte() % 8) {
    case 0:
      return run_laser<sick::SickDriver>(input, sick::SickOptions{});
    case 1:
      return run_laser<hokuyo::HokuyoDriver>(input, hokuyo::HokuyoOptions{});
    case 2:
      return run_laser<rplidar::RplidarDriver>(input, rplidar::RplidarOptions{});
    case 3:
      return run_laser<leuze::LeuzeDriver>(input, leuze::LeuzeOptions{});
    case 4:
      return run_laser<leuze::LeuzeServiceDriver>(input, leuze::LeuzeOptions{});
    case 5:
      return run_laser<ldlidar::LdlidarDriver>(input, ldlidar::LdlidarOptions{});
    case 6:
      return run_laser<cola::ColaDriver>(input, cola::ColaOptions{});
    default:
      return run_laser<ydlidar::YdlidarDriver>(input, ydlidar::YdlidarOptions{});
  }
}

/// Steps a driver without port: pieces of the input, each after as much time as its first byte
/// says.
template <class Driver, class Drain>
void run_board(Driver& driver, Input input, Drain drain) {
  Utime now = kStart;
  std::vector<uint8_t> out;
  driver.on_connection(true, now);
  for (int i = 0; i < kSteps && (i < 20 || !input.empty()); ++i) {
    now = now + Duration::from_us(1000 + input.byte() * 1000);
    driver.receive(input.take(1U + input.byte() % 64U), now);
    driver.advance(now, out);
    promise(out.size() < 100000, "a driver does not babble");
    drain(now);
    promise(!driver.state().empty(), "a driver says how it is");
  }
  driver.on_connection(false, now);
}

void drive(BaseDriver& driver, Input input) {
  BaseCommand command;
  command.id = 1;
  command.kind = static_cast<BaseCommand::Kind>(input.byte() % 6);
  command.distance_m = input.byte() / 10.0;
  command.angle_rad = input.byte() / 40.0;
  command.velocity_m_per_s = 0.1;
  command.utime = kStart;
  driver.command(command, kStart);
  run_board(driver, input, [&](Utime now) {
    for (const OdometrySample& sample : driver.take_output().odometry) {
      promise(std::isfinite(sample.odom_from_robot.x_m) &&
                  std::isfinite(sample.odom_from_robot.theta_rad),
              "odometry is a number");
    }
    command.utime = now;
    if (now.us % 7 == 0) driver.command(command, now);
  });
}

MARCO_FUZZ(probe) {
  devices::judge(bytes, devices::Kind::silence);
  Input input(bytes);
  const auto asked = static_cast<devices::Kind>(input.byte() % 17);
  devices::judge(input.rest(), asked);
  FuzzStream stream(input);
  const auto finding = devices::probe(
      stream, [&stream] { return stream.now(); }, devices::Manner::ask);
  promise(!devices::is_device(finding.claim.kind) || finding.baud > 0, "a device has a rate");
  promise((stream.now() - kStart).seconds() < 60.0, "a probe ends");
}

MARCO_FUZZ(base_driver) {
  Input input(bytes);
  const int which = input.byte() % 5;
  if (which == 3) {
    create::CreateBase driver{create::CreateOptions{}};
    drive(driver, input);
  } else if (which == 4) {
    kobuki::KobukiBase driver{kobuki::KobukiOptions{}};
    drive(driver, input);
  } else if (which == 0) {
    hcs12::Hcs12Base driver{hcs12::Hcs12BaseOptions{}};
    drive(driver, input);
  } else if (which == 2) {
    textbase::TextBaseOptions options;
    options.ticks_per_turn = 1440.0;
    options.wheel_diameter_m = 0.065;
    options.track_m = 0.16;
    textbase::TextBase driver(options);
    drive(driver, input);
  } else {
    p2os::P2osBase driver{p2os::P2osOptions{}};
    drive(driver, input);
  }
}

MARCO_FUZZ(board_driver) {
  Input input(bytes);
  if (input.byte() % 2 == 0) {
    hcs12::PanTiltDriver driver{hcs12::PanTiltOptions{}};
    PanTiltCommand command;
    command.kind = PanTiltCommand::Kind::go_to;
    command.tilt_rad = 0.2;
    driver.command(command, kStart);
    run_board(driver, input, [&driver](Utime) {
      for (const PanTiltState& state : driver.take_states()) {
        promise(std::isfinite(state.pan_rad) && std::isfinite(state.tilt_rad),
                "angles are numbers");
      }
    });
  } else {
    imu::ImuDriver driver{imu::ImuOptions{}};
    run_board(driver, input, [&driver](Utime) { driver.take_samples(); });
  }
}

std::unique_ptr<Emulator> emulator_of(uint8_t choice) {
  const LaserWorld world = [](const LaserSweep& sweep) {
    promise(sweep.beams >= 0 && sweep.beams < 100000, "a sweep has its laser's beams");
    return std::vector<double>(static_cast<std::size_t>(sweep.beams), 1.0);
  };
  switch (choice % 14) {
    case 0:
      return std::make_unique<sick::SickEmulator>(world, sick::SickEmulatorOptions{});
    case 1:
      return std::make_unique<hokuyo::HokuyoEmulator>(world, hokuyo::HokuyoEmulatorOptions{});
    case 2:
      return std::make_unique<rplidar::RplidarEmulator>(world, rplidar::RplidarEmulatorOptions{});
    case 3:
      return std::make_unique<leuze::LeuzeEmulator>(world, leuze::LeuzeEmulatorOptions{});
    case 4:
      return std::make_unique<hcs12::BaseEmulator>(hcs12::BaseWorld{},
                                                   hcs12::BaseEmulatorOptions{});
    case 5:
      return std::make_unique<hcs12::PanTiltEmulator>(hcs12::PanTiltEmulatorOptions{});
    case 6:
      return std::make_unique<p2os::P2osEmulator>();
    case 7:
      return std::make_unique<imu::ImuEmulator>([](Utime) { return imu::Motion{}; });
    case 8:
      return std::make_unique<ldlidar::LdlidarEmulator>(world, ldlidar::LdlidarEmulatorOptions{});
    case 9:
      return std::make_unique<textbase::TextBoard>();
    case 10:
      return std::make_unique<create::CreateEmulator>();
    case 12:
      return std::make_unique<bno055::Bno055Emulator>([](Utime) { return imu::Motion{}; });
    case 11:
      return std::make_unique<cola::ColaEmulator>(world, cola::ColaEmulatorOptions{});
    default:
      return std::make_unique<ydlidar::YdlidarEmulator>(world, ydlidar::YdlidarEmulatorOptions{});
  }
}

MARCO_FUZZ(emulator) {
  Input input(bytes);
  const auto emulator = emulator_of(input.byte());
  Utime now = kStart;
  std::vector<uint8_t> out;
  emulator->on_connection(true, now);
  for (int i = 0; i < kSteps && (i < 4 || !input.empty()); ++i) {
    now = now + Duration::from_us(1 + input.byte() * 2000);
    emulator->receive(input.take(1U + input.byte() % 64U), 9600, now);
    emulator->advance(now, out);
    emulator->next_event();
    out.clear();
  }
}

}  // namespace
}  // namespace marco::fuzz
