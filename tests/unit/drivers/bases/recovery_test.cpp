// What a line may do to the drivers of bases, head and inertial sensor, alike for all; the times
// are printed. (Lasers: lasers_recovery_test.cpp.)
#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "bench.hpp"
#include "drivers/create/driver.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "drivers/hcs12/pantilt_driver.hpp"
#include "drivers/imu/driver.hpp"
#include "drivers/kobuki/driver.hpp"
#include "drivers/p2os/driver.hpp"
#include "drivers/textbase/driver.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/hcs12/base_emulator.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"
#include "simulator/devices/imu/emulator.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"

namespace marco::drivers {
namespace {

constexpr double kReturnS = 2.0;  // the promise: the first valid byte is answered within it

/// `up` as the driver sees its device; `reset` may be empty. @param own_s the device's own time
/// after a reset.
template <class Driver>
void expect_returns(const char* name,
                    testing::Bench<Driver>& bench,
                    const std::function<bool()>& up,
                    const std::function<void()>& reset,
                    double own_s) {
  const auto back = [&](const char* after, double limit_s) {
    const Utime since = bench.now();
    EXPECT_TRUE(bench.run_until(limit_s + 3.0, up)) << name << " after " << after;
    const double took_s = (bench.now() - since).seconds();
    std::printf("%-9s %-8s is back after %5.2f s (may take %.1f)\n", name, after, took_s, limit_s);
    EXPECT_LE(took_s, limit_s) << name << " after " << after;
    bench.run(0.3);
  };
  back("start", kReturnS + own_s);
  bench.plug(false);
  bench.run(3.0);
  EXPECT_FALSE(up()) << name << " unplugged";
  bench.plug(true);
  back("plug", kReturnS);
  if (reset) {
    reset();
    bench.run(0.4);
    back("reset", kReturnS + own_s);
  }
  bench.spoil = [](std::vector<uint8_t>& bytes) { bytes.clear(); };
  bench.run(4.0);
  EXPECT_FALSE(up()) << name << " silent";
  bench.spoil = nullptr;
  back("silence", kReturnS);
  std::mt19937 random(4);
  bench.spoil = [&random](std::vector<uint8_t>& bytes) {
    bytes.resize(40);  // 80 kB/s
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  };
  bench.run(4.0);
  EXPECT_FALSE(up()) << name << " flooded: noise is no answer";
  bench.spoil = nullptr;
  back("flood", kReturnS);
}

TEST(Recovery, Hcs12Base) {
  hcs12::BaseEmulator board({}, {});
  hcs12::Hcs12Base driver({});
  testing::Bench<hcs12::Hcs12Base> bench(driver, board, hcs12::kBaud);
  expect_returns<hcs12::Hcs12Base>(
      "HCS12", bench, [&] { return driver.status().link == BaseStatus::Link::up; },
      [&] { board.reset(bench.now()); }, 0.5);
}

TEST(Recovery, PanTilt) {
  hcs12::PanTiltEmulator board({});
  hcs12::PanTiltDriver driver({});
  testing::Bench<hcs12::PanTiltDriver> bench(driver, board, hcs12::kBaud);
  // Homing: to both ends and back.
  expect_returns<hcs12::PanTiltDriver>(
      "pan-tilt", bench, [&] { return driver.link() == hcs12::PanTiltDriver::Link::up; },
      [&] { board.reset(bench.now()); }, 15.0);
}

TEST(Recovery, Pioneer) {
  p2os::P2osEmulator robot;
  p2os::P2osBase driver({});
  testing::Bench<p2os::P2osBase> bench(driver, robot, p2os::kBaud);
  expect_returns<p2os::P2osBase>(
      "Pioneer", bench, [&] { return driver.status().link == BaseStatus::Link::up; },
      [&] { robot.reset(); }, 0.5);
}

TEST(Recovery, Create) {
  create::CreateEmulator robot;
  create::CreateBase driver({});
  testing::Bench<create::CreateBase> bench(driver, robot, create::kBaud);
  expect_returns<create::CreateBase>(
      "Create", bench, [&] { return driver.status().link == BaseStatus::Link::up; },
      [&] { robot.reset(bench.now()); }, 1.0);
}

TEST(Recovery, Kobuki) {
  kobuki::KobukiEmulator robot;
  kobuki::KobukiBase driver({});
  testing::Bench<kobuki::KobukiBase> bench(driver, robot, kobuki::kBaud);
  expect_returns<kobuki::KobukiBase>(
      "Kobuki", bench, [&] { return driver.status().link == BaseStatus::Link::up; },
      [&] { robot.reset(bench.now()); }, 1.0);
}

TEST(Recovery, TextBase) {
  textbase::TextBoard board;
  textbase::TextBaseOptions options;
  options.ticks_per_turn = 1440.0;
  options.wheel_diameter_m = 0.065;
  options.track_m = 0.16;
  textbase::TextBase driver(options);
  testing::Bench<textbase::TextBase> bench(driver, board, textbase::kBaud);
  expect_returns<textbase::TextBase>(
      "text base", bench, [&] { return driver.status().link == BaseStatus::Link::up; },
      [&] { board.reset(bench.now()); }, 1.0);
}

TEST(Recovery, Imu) {
  imu::ImuEmulator sensor([](Utime) { return imu::Motion{}; });
  imu::ImuOptions options;
  imu::ImuDriver driver(options);
  testing::Bench<imu::ImuDriver> bench(driver, sensor, options.baud);
  expect_returns<imu::ImuDriver>(
      "IMU", bench, [&] { return driver.alive(); }, {}, 0.5);
}

/// The host's clock is set an hour ahead and back, as DriverLoop tells drivers: line and session
/// begun anew. @param newest  stamp of what was told last.
template <class Driver>
void expect_stamps_follow(testing::Bench<Driver>& bench, const std::function<Utime()>& newest) {
  bench.run(3.0);
  for (const double ahead_s : {0.0, 3600.0, 0.0}) {
    bench.plug(false);
    bench.host_ahead = Duration::from_seconds(ahead_s);
    bench.plug(true);
    bench.run(3.0);
    const Duration age = bench.now() + bench.host_ahead - newest();
    EXPECT_GE(age.us, 0) << ahead_s;
    EXPECT_LT(age.seconds(), 1.5) << ahead_s;
  }
}

TEST(Recovery, StampsFollowAClockThatIsSetBack) {
  hcs12::BaseEmulator board({}, {});
  hcs12::Hcs12Base base({});
  testing::Bench<hcs12::Hcs12Base> base_bench(base, board, hcs12::kBaud);
  // Nothing at all is told when a deadline is an hour ahead.
  const auto newest = [](const auto& samples) {
    return samples.empty() ? Utime{} : samples.back().utime;
  };
  expect_stamps_follow<hcs12::Hcs12Base>(base_bench,
                                         [&] { return newest(base.take_output().odometry); });
  hcs12::PanTiltEmulator head_board({});
  hcs12::PanTiltDriver head({});
  testing::Bench<hcs12::PanTiltDriver> head_bench(head, head_board, hcs12::kBaud);
  expect_stamps_follow<hcs12::PanTiltDriver>(head_bench,
                                             [&] { return newest(head.take_states()); });
  p2os::P2osEmulator robot;
  p2os::P2osBase pioneer({});
  testing::Bench<p2os::P2osBase> pioneer_bench(pioneer, robot, p2os::kBaud);
  expect_stamps_follow<p2os::P2osBase>(pioneer_bench,
                                       [&] { return newest(pioneer.take_output().odometry); });
}

// A laser that fails before a wall: the wall is still there.
}  // namespace
}  // namespace marco::drivers
