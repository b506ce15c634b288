// What a laser's line may do to its driver, alike for all of them; the times are printed.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "drivers/cola/driver.hpp"
#include "drivers/hokuyo/driver.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "drivers/leuze/driver.hpp"
#include "drivers/rplidar/driver.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/ydlidar/driver.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "simulator/devices/leuze/emulator.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/ydlidar/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers {
namespace {

// Random rounds, of which a short run under the sanitizers takes a part (CMakePresets.json).
int rounds(int all) {
  const char* percent = std::getenv("MARCO_PERCENT_OF_ROUNDS");
  return percent == nullptr ? all : std::max(1, all * std::atoi(percent) / 100);
}

/// A laser, its line and its driver. own_s: what the device itself takes (devices.md) from its
/// return until it can measure, power-on and settings included.
struct Device {
  const char* name;
  double own_s;
  double reset_s;  ///< what its reset adds; below 0: it has none that a host or a test can press
  bool has_baud;
  std::unique_ptr<Emulator> emulator;
  std::function<void(Utime)> reset;
  LineSettings wrong;  ///< not the device's speed
  std::function<std::unique_ptr<LaserDriver>(ByteStream&, Clock)> driver;
};

Device sick_laser() {
  sick::SickEmulatorOptions options;
  options.power_on_s = 5.0;
  options.baud = 19200;
  auto laser = std::make_unique<sick::SickEmulator>(test_world, options);
  sick::SickEmulator* pressed = laser.get();
  // Rates to try, 0.25 s of settling, ten replies, a configuration of 0.3 s.
  return {"SICK",
          1.5,
          5.0,
          true,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {500'000},
          [](ByteStream& stream, Clock clock) {
            sick::SickOptions wanted;
            wanted.baud = 38400;
            return std::make_unique<sick::SickDriver>(stream, wanted, clock);
          }};
}

/// At the speed that carries every scan: the line is never silent.
Device fast_sick_laser() {
  Device device = sick_laser();
  device.name = "SICK500k";
  device.driver = [](ByteStream& stream, Clock clock) {
    sick::SickOptions wanted;
    wanted.baud = 500'000;
    return std::make_unique<sick::SickDriver>(stream, wanted, clock);
  };
  device.wrong = {38400};
  return device;
}

Device hokuyo_laser() {
  hokuyo::HokuyoEmulatorOptions options;
  options.baud = 19200;
  auto laser = std::make_unique<hokuyo::HokuyoEmulator>(test_world, options);
  hokuyo::HokuyoEmulator* pressed = laser.get();
  return {"Hokuyo",
          1.0,
          0.3,
          true,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {750'000},
          [](ByteStream& stream, Clock clock) {
            hokuyo::HokuyoOptions wanted;
            wanted.baud = 115'200;
            return std::make_unique<hokuyo::HokuyoDriver>(stream, wanted, clock);
          }};
}

Device rplidar_laser(const char* name,
                     double own_s,
                     const rplidar::RplidarEmulatorOptions& options) {
  auto laser = std::make_unique<rplidar::RplidarEmulator>(test_world, options);
  rplidar::RplidarEmulator* pressed = laser.get();
  return {name,
          own_s,
          0.5,
          true,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {9600},
          [](ByteStream& stream, Clock clock) {
            return std::make_unique<rplidar::RplidarDriver>(stream, rplidar::RplidarOptions{},
                                                            clock);
          }};
}
// A turn takes 0.18 s, or 0.1 s; the first one is not whole. Each rate that is not the laser's
// costs 0.7 s.
Device a1_laser() { return rplidar_laser("RPLIDAR", 0.6, {}); }
Device c1_laser() { return rplidar_laser("C1", 1.1, rplidar::c1()); }
Device s2_laser() { return rplidar_laser("S2", 1.8, rplidar::s2()); }

Device a3_laser() { return rplidar_laser("A3", 2.5, rplidar::a3()); }

Device ldlidar_laser(const char* name, const ldlidar::LdlidarEmulatorOptions& options) {
  auto laser = std::make_unique<ldlidar::LdlidarEmulator>(test_world, options);
  ldlidar::LdlidarEmulator* pressed = laser.get();
  // 0.3 s of learning its period, a turn of 0.1 s after the first, which is not whole.
  return {name,
          0.5,
          options.power_on_s,
          true,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {9600},
          [](ByteStream& stream, Clock clock) {
            return std::make_unique<ldlidar::LdlidarDriver>(stream, ldlidar::LdlidarOptions{},
                                                            clock);
          }};
}
Device ld19_laser() { return ldlidar_laser("LD19", {}); }
Device stl27l_laser() { return ldlidar_laser("STL27L", ldlidar::stl27l()); }

Device ydlidar_laser(const char* name,
                     double own_s,
                     const ydlidar::YdlidarEmulatorOptions& options) {
  auto laser = std::make_unique<ydlidar::YdlidarEmulator>(test_world, options);
  ydlidar::YdlidarEmulator* pressed = laser.get();
  return {name,
          own_s,
          options.power_on_s,
          true,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {9600},
          [](ByteStream& stream, Clock clock) {
            return std::make_unique<ydlidar::YdlidarDriver>(stream, ydlidar::YdlidarOptions{},
                                                            clock);
          }};
}
// The motor's 0.5 s, 1 s of learning the period, two turns of 0.14 s; an X2 is asked three times.
Device x4_laser() { return ydlidar_laser("X4", 1.8, {}); }
Device g4_laser() { return ydlidar_laser("G4", 1.8, ydlidar::g4()); }
Device x2_laser() { return ydlidar_laser("X2", 2.7, ydlidar::x2()); }

Device tim_laser() {
  const cola::ColaEmulatorOptions options;
  auto laser = std::make_unique<cola::ColaEmulator>(test_world, options);
  cola::ColaEmulator* pressed = laser.get();
  return {"TiM561",
          0.5,
          options.power_on_s + options.warm_up_s,
          false,
          std::move(laser),
          [pressed](Utime now) { pressed->power_cycle(now); },
          {},
          [](ByteStream& stream, Clock clock) {
            return std::make_unique<cola::ColaDriver>(stream, cola::ColaOptions{}, clock);
          }};
}

Device leuze_laser() {
  return {"Leuze",
          0.2,
          -1.0,
          true,
          std::make_unique<leuze::LeuzeEmulator>(test_world, leuze::LeuzeEmulatorOptions{}),
          {},
          {9600},
          [](ByteStream& stream, Clock clock) {
            return std::make_unique<leuze::LeuzeDriver>(stream, leuze::LeuzeOptions{}, clock);
          }};
}

class LaserRecovery : public ::testing::TestWithParam<Device (*)()> {
 protected:
  LaserRecovery() : device_(GetParam()()), line_(*device_.emulator, device_.has_baud) {}

  void connect(const LineSettings& settings = {}) {
    driver_.reset();
    stream_.reset();
    stream_ = line_.open(settings);
    driver_ = device_.driver(*stream_, [this] { return line_.now(); });
  }
  /// @returns seconds until a scan came, or a negative number.
  double scan_within(double limit_s) {
    const Utime since = line_.now();
    const bool came = !step_until(*driver_, line_, limit_s, have(1)).empty();
    return came ? (line_.now() - since).seconds() : -1.0;
  }
  /// From `since` on a scan must come within 2 s, the device's own times and 1 s more.
  void expect_back(const char* after, double own_s) {
    const double limit_s = 2.0 + own_s + 1.0;
    const double back_s = scan_within(limit_s + 5.0);
    std::printf("%-8s %-12s scans again after %5.2f s (may take %.1f)\n", device_.name, after,
                back_s, limit_s);
    EXPECT_GE(back_s, 0.0) << after << ": " << driver_->state();
    EXPECT_LE(back_s, limit_s) << after;
  }
  /// Of the scans' ranges to the world's at the times they claim.
  double worst_error_m(const std::vector<ArrivedScan>& scans) const {
    double worst_m = 0.0;
    for (const ArrivedScan& arrived : scans) {
      worst_m = std::max(worst_m, worst_range_error_m(arrived.scan));
    }
    return worst_m;
  }

  Device device_;
  SimulatedLine line_;
  std::unique_ptr<ByteStream> stream_;
  std::unique_ptr<LaserDriver> driver_;
};

TEST_P(LaserRecovery, PlugResetSpeedSilenceAndFlood) {
  connect(device_.wrong);  // nobody has set the line's speed
  expect_back("wrong baud", device_.own_s);

  line_.at(line_.now() + Duration::from_us(10'000), [&] { line_.unplug(); });
  EXPECT_THROW(step_until(*driver_, line_, 3.0, have(10'000)), StreamLost);
  line_.wait(Duration::from_seconds(3.0));
  line_.plug_in();
  connect(device_.wrong);
  expect_back("plug", device_.own_s);

  if (device_.reset) {
    line_.at(line_.now() + Duration::from_us(7'000), [&] { device_.reset(line_.now()); });
    step_until(*driver_, line_, 0.05, have(10'000));  // in mid-scan
    expect_back("reset", device_.own_s + device_.reset_s);
  }

  line_.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  step_until(*driver_, line_, 4.0, have(10'000));
  EXPECT_EQ(scan_within(1.0), -1.0);
  EXPECT_THAT(driver_->state(), ::testing::Not(::testing::HasSubstr("measuring at")));
  line_.set_tamper_to_client({});
  expect_back("silence", device_.own_s);

  std::mt19937 random(6);
  line_.set_tamper_to_client([&random](Bytes& bytes) {
    bytes.resize(bytes.size() + 400);  // more than any line carries
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  });
  EXPECT_TRUE(step_until(*driver_, line_, 4.0, have(10'000)).empty()) << "a scan made of noise";
  EXPECT_GT(driver_->counts().garbage_bytes, 1000);
  line_.set_tamper_to_client({});
  expect_back("flood", device_.own_s);
}

TEST_P(LaserRecovery, ACableCutAtAnyTimeForAnyTime) {
  connect(device_.wrong);
  expect_back("wrong baud", device_.own_s);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> cut_s(0.05, 3.0), whole_s(0.0, 0.4);
  double worst_s = 0.0;
  for (int i = 0; i < rounds(40); ++i) {
    step_until(*driver_, line_, whole_s(random), have(10'000));
    // What is cut off in the middle of a request or a scan differs from round to round.
    line_.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
    line_.set_tamper_to_device([](Bytes& bytes) { bytes.clear(); });
    step_until(*driver_, line_, cut_s(random), have(10'000));
    line_.set_tamper_to_client({});
    line_.set_tamper_to_device({});
    const double back_s = scan_within(10.0);
    ASSERT_GE(back_s, 0.0) << "cut " << i << ": " << driver_->state();
    worst_s = std::max(worst_s, back_s);
  }
  std::printf("%-8s cable cut    scans again after %5.2f s at most\n", device_.name, worst_s);
  EXPECT_LE(worst_s, 2.0 + device_.own_s + 1.0);
}

// A busy machine lets an emulator, or the host's serial port, stand still for a tenth of a second
// now and then, between the bytes of a reply, too.
TEST_P(LaserRecovery, AMachineThatStandsStillNowAndThen) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> pause_s(0.03, 0.12), between_s(0.02, 0.3);
  double worst_s = 0.0;
  for (int i = 0; i < rounds(300); ++i) {
    connect(device_.wrong);
    if (device_.reset) device_.reset(line_.now());
    const std::function<void()> pause = [&] {
      line_.hold_up(line_.now() + Duration::from_seconds(pause_s(random)));
      line_.at(line_.now() + Duration::from_seconds(0.12 + between_s(random)), pause);
    };
    line_.at(line_.now(), pause);
    const double back_s = scan_within(20.0);
    ASSERT_GE(back_s, 0.0) << "start " << i << ": " << driver_->state();
    worst_s = std::max(worst_s, back_s);
    line_.forget_actions();
  }
  std::printf("%-8s standing still scans after %5.2f s at most\n", device_.name, worst_s);
  EXPECT_LE(worst_s, 3.0 + device_.own_s + std::max(0.0, device_.reset_s) + 1.0);
}

// A busy host reads nothing for a while, then all that waited at once, none of it lost: each scan
// was measured when it was.
TEST_P(LaserRecovery, ScansThatWaitedAShortWhileHaveRightStamps) {
  connect(device_.wrong);
  ASSERT_GE(step_until(*driver_, line_, 20.0, have(40)).size(), 40u);
  const double before_m = worst_error_m(step_until(*driver_, line_, 10.0, have(20)));
  for (const double pause_s : {0.1, 0.2, 0.3, 0.45}) {
    line_.wait(Duration::from_seconds(pause_s));
    const std::vector<ArrivedScan> scans = step_until(*driver_, line_, 10.0, have(30));
    ASSERT_GE(scans.size(), 30u) << driver_->state();
    const double after_m = worst_error_m(scans);
    std::printf("%-8s busy host    ranges within %.4f m before, %.4f m after %.2f s\n",
                device_.name, before_m, after_m, pause_s);
    EXPECT_LT(after_m, before_m + 0.02);
  }
}

// As a laser's process does it: what waited is thrown away, and the driver told.
TEST_P(LaserRecovery, StampsAreRightAfterTheHostStoodStill) {
  connect(device_.wrong);
  ASSERT_GE(step_until(*driver_, line_, 20.0, have(20)).size(), 20u);
  const double before_m = worst_error_m(step_until(*driver_, line_, 10.0, have(20)));
  for (const double pause_s : {0.6, 1.4, 0.8}) {
    line_.wait(Duration::from_seconds(pause_s));
    driver_->step();
    uint8_t old[4096];
    const Utime until = line_.now() + Duration::from_seconds(0.3);
    while (line_.now() < until) stream_->read(old, std::chrono::milliseconds(20));
    driver_->on_input_flushed();
    const std::vector<ArrivedScan> scans = step_until(*driver_, line_, 10.0, have(20));
    ASSERT_GE(scans.size(), 20u) << driver_->state();
    const double after_m = worst_error_m(scans);
    std::printf("%-8s stood still  ranges within %.4f m before, %.4f m after %.1f s\n",
                device_.name, before_m, after_m, pause_s);
    EXPECT_LT(after_m, before_m + 0.02);  // the world moves by up to 3.5 m/s
  }
}

INSTANTIATE_TEST_SUITE_P(Lasers,
                         LaserRecovery,
                         ::testing::Values(sick_laser,
                                           fast_sick_laser,
                                           hokuyo_laser,
                                           tim_laser,
                                           a1_laser,
                                           c1_laser,
                                           s2_laser,
                                           a3_laser,
                                           ld19_laser,
                                           stl27l_laser,
                                           x2_laser,
                                           x4_laser,
                                           g4_laser,
                                           leuze_laser),
                         [](const auto& one) { return std::string(one.param().name); });

}  // namespace
}  // namespace marco::drivers
