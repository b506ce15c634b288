#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "drivers/hcs12/pantilt_driver.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"

namespace marco::drivers::hcs12 {
namespace {

struct Head {
  explicit Head(const PanTiltEmulatorOptions& firmware = {})
      : board(firmware), driver(options), bench(driver, board, 9600) {
    bench.each_step = [this](Utime now) {
      for (const PanTiltState& state : driver.take_states()) states.push_back(state);
      truth.push_back({now, board.pan_units(), board.tilt_units()});
    };
    EXPECT_TRUE(bench.run_until(8.0, [this] { return driver.link() == PanTiltDriver::Link::up; }));
    bench.run(0.3);
  }
  void order(double pan_deg, double tilt_deg, double rate_deg_per_s = 0.0) {
    PanTiltCommand command;
    command.kind = PanTiltCommand::Kind::go_to;
    command.pan_rad = deg_to_rad(pan_deg);
    command.tilt_rad = deg_to_rad(tilt_deg);
    command.pan_rate_rad_per_s = command.tilt_rate_rad_per_s = deg_to_rad(rate_deg_per_s);
    driver.command(command, bench.now());
  }
  bool arrive(double seconds) {
    return bench.run_until(seconds, [this] { return !driver.moving(); });
  }
  double pan_deg() const { return board.pan_units() * options.pan.deg_per_unit; }
  double tilt_deg() const { return -20.0 + board.tilt_units() * options.tilt.deg_per_unit; }

  /// Largest difference between the states told since `from` and the truth at their stamps.
  double worst_tilt_error_deg(std::size_t from) const {
    double worst = 0.0;
    for (std::size_t i = from; i < states.size(); ++i) {
      const auto at = std::lower_bound(truth.begin(), truth.end(), states[i].utime,
                                       [](const Truth& t, Utime when) { return t.when < when; });
      if (at == truth.end()) continue;
      const double true_deg = -20.0 + at->tilt * options.tilt.deg_per_unit;
      worst = std::max(worst, std::abs(rad_to_deg(states[i].tilt_rad) - true_deg));
    }
    return worst;
  }

  struct Truth {
    Utime when;
    double pan, tilt;
  };
  PanTiltOptions options;
  PanTiltEmulator board;
  PanTiltDriver driver;
  testing::Bench<PanTiltDriver> bench;
  std::vector<PanTiltState> states;
  std::vector<Truth> truth;
};

TEST(PanTiltDriver, LooksWhereItIsTold) {
  Head head;
  head.order(90.0, 10.0);
  ASSERT_TRUE(head.driver.moving());
  EXPECT_TRUE(head.arrive(20.0));
  // Half a unit of rounding.
  EXPECT_NEAR(head.pan_deg(), 90.0, 0.8);
  EXPECT_NEAR(head.tilt_deg(), 10.0, 0.4);
  EXPECT_NEAR(rad_to_deg(head.states.back().pan_rad), head.pan_deg(), 0.05);
  EXPECT_NEAR(rad_to_deg(head.states.back().tilt_rad), head.tilt_deg(), 0.05);
  head.order(-90.0, 80.0);  // 270 deg, and clipped at 45 deg
  EXPECT_TRUE(head.arrive(20.0));
  EXPECT_NEAR(head.pan_deg(), 270.0, 0.8);
  EXPECT_NEAR(head.tilt_deg(), 45.0, 0.4);
}

TEST(PanTiltDriver, ASlowSweepIsToldToSomeHundredthsOfADegree) {
  Head head;
  const std::size_t from = head.states.size();
  head.order(0.0, 45.0, 5.5);
  EXPECT_TRUE(head.arrive(30.0));
  EXPECT_GT(head.states.size() - from, 100U);
  // In the ramp a late index pulse may cost part of a printing; steady, a stamp's millisecond or
  // two at 5.5 deg/s and some clicks.
  EXPECT_LT(head.worst_tilt_error_deg(from), 0.12);
  EXPECT_LT(head.worst_tilt_error_deg(from + 20), 0.05);
}

TEST(PanTiltDriver, AFastMoveIsFollowedByItsRamp) {
  Head head;
  const std::size_t from = head.states.size();
  head.order(0.0, 45.0, 20.0);
  EXPECT_TRUE(head.arrive(30.0));
  EXPECT_GT(head.states.size() - from, 100U);
  EXPECT_LT(head.worst_tilt_error_deg(from), 3.0);  // 5 % of the way: not for sweeps
  EXPECT_NEAR(head.tilt_deg(), 45.0, 0.4);
}

TEST(PanTiltDriver, TheManualsBoardIsReadToo) {
  PanTiltEmulatorOptions manual;
  manual.listing_status = manual.listing_stop = false;
  Head head(manual);
  const std::size_t from = head.states.size();
  head.order(0.0, 45.0, 5.5);
  EXPECT_TRUE(head.arrive(30.0));
  EXPECT_NEAR(head.tilt_deg(), 45.0, 0.4);
  EXPECT_LT(head.worst_tilt_error_deg(from), 0.65);  // whole units only: one of them
}

// Before the driver knows which of the two it has.
TEST(PanTiltDriver, ItsGuardianStopsEitherBoard) {
  for (const bool listing : {true, false}) {
    PanTiltEmulatorOptions firmware;
    firmware.listing_stop = listing;
    Head head(firmware);
    head.order(170.0, 0.0, 12.0);
    head.bench.run(4.0);
    ASSERT_TRUE(head.driver.moving());
    std::vector<uint8_t> stop;
    head.driver.shut_down(stop);
    head.bench.frozen = true;
    head.bench.run(0.5);
    const double at_deg = head.pan_deg();
    for (int i = 0; i < 30; ++i) {
      head.bench.inject(stop);
      head.bench.run(0.1);
    }
    EXPECT_NEAR(head.pan_deg(), at_deg, 12.0) << listing;  // where it was half a second before
    const double stood_deg = head.pan_deg();
    head.bench.run(2.0);
    EXPECT_EQ(head.pan_deg(), stood_deg) << listing;
  }
}

TEST(PanTiltDriver, StopsEitherBoard) {
  for (const bool listing : {true, false}) {
    PanTiltEmulatorOptions firmware;
    firmware.listing_stop = listing;
    Head head(firmware);
    head.order(180.0, 0.0, 5.0);
    head.bench.run(3.0);
    const double at_deg = head.pan_deg();
    head.driver.command(PanTiltCommand{}, head.bench.now());
    EXPECT_TRUE(head.arrive(3.0)) << listing;
    EXPECT_LT(head.pan_deg() - at_deg, 6.0) << listing;
    head.order(90.0, 10.0);
    EXPECT_TRUE(head.arrive(20.0)) << listing;
    EXPECT_NEAR(head.pan_deg(), 90.0, 0.8) << listing;
  }
}

TEST(PanTiltDriver, ANewOrderTurnsBackInMidMove) {
  Head head;
  head.order(180.0, 40.0, 5.0);
  head.bench.run(4.0);
  head.order(10.0, -10.0);
  EXPECT_TRUE(head.bench.run_until(30.0, [&] { return !head.driver.moving(); }));
  EXPECT_NEAR(head.pan_deg(), 10.0, 0.8);
  EXPECT_NEAR(head.tilt_deg(), -10.0, 0.4);
}

TEST(PanTiltDriver, AResetLeadsHomeAgain) {
  Head head;
  head.order(20.0, 0.0);
  head.bench.run(0.5);
  head.board.reset(head.bench.now());
  EXPECT_TRUE(
      head.bench.run_until(1.0, [&] { return head.driver.link() == PanTiltDriver::Link::homing; }));
  EXPECT_TRUE(
      head.bench.run_until(20.0, [&] { return head.driver.link() == PanTiltDriver::Link::up; }));
  EXPECT_TRUE(head.board.homed());
  EXPECT_FALSE(head.driver.moving());
}

TEST(PanTiltDriver, SilenceIsToldAndEnds) {
  Head head;
  head.bench.deaf = true;
  EXPECT_TRUE(
      head.bench.run_until(2.0, [&] { return head.driver.link() == PanTiltDriver::Link::down; }));
  head.bench.deaf = false;
  EXPECT_TRUE(
      head.bench.run_until(2.0, [&] { return head.driver.link() == PanTiltDriver::Link::up; }));
}

TEST(PanTiltDriver, ASlowOrderArrives) {
  Head head;
  head.order(3.0, -20.0, 1.0);  // less than a click a tick
  EXPECT_TRUE(head.driver.moving());
  EXPECT_TRUE(head.arrive(10.0));
  EXPECT_NEAR(head.pan_deg(), 3.0, 0.5);
}

}  // namespace
}  // namespace marco::drivers::hcs12
