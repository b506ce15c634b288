// A base never runs away: orders hold for their time only, an emergency stop holds until it is
// released, and whatever dies, the wheels stop by themselves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "any_base.hpp"
#include "common/order_age.hpp"

namespace marco::drivers {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Fate = BaseStatus::Command;
using Kind = BaseCommand::Kind;
using testing::Hcs12;
using testing::Pioneer;

/// What all bases do alike.
template <class Base>
class AnyBase : public ::testing::Test {
 protected:
  Base base_;

  BaseCommand order(Kind kind, double age_s) {
    BaseCommand command;
    command.kind = kind;
    command.distance_m = command.angle_rad = 0.5;
    command.velocity_m_per_s = 0.1;
    command.point_m = {0.5, 0.0};
    command.utime = base_.bench.host_now() - Duration::from_seconds(age_s);
    return command;
  }
  EmergencyStop stop(bool engaged, double age_s = 0.0) {
    return {base_.bench.host_now() - Duration::from_seconds(age_s), engaged, "sheriff", "a child"};
  }
  void send(const EmergencyStop& message) {
    base_.driver.emergency_stop(message, base_.bench.host_now());
  }
  std::string note() const { return base_.driver.status().note; }
};
TYPED_TEST_SUITE(AnyBase, testing::Bases);

constexpr Kind kMotions[] = {Kind::move, Kind::turn, Kind::velocity, Kind::go_to};

TYPED_TEST(AnyBase, OldOrdersAndThoseFromTheFutureAreRefused) {
  auto& base = this->base_;
  for (const Kind kind : kMotions) {
    for (const double age_s : {0.7, 30.0, 4000.0 * 86400.0, -0.7, -86400.0}) {
      base.begin(this->order(kind, age_s));
      EXPECT_EQ(base.driver.status().command, Fate::refused) << age_s;
      base.bench.run(0.3);
      EXPECT_FALSE(base.moves()) << static_cast<int>(kind) << " " << age_s;
    }
    // Two computers' clocks are never quite the same.
    for (const double age_s : {0.4, -0.4}) {
      base.begin(this->order(kind, age_s));
      EXPECT_EQ(base.driver.status().command, Fate::running) << age_s;
      base.begin(this->order(Kind::stop, 0.0));
      base.bench.run(1.0);
    }
  }
  base.begin(this->order(Kind::move, 3.24));
  EXPECT_THAT(this->note(), StartsWith("order is 3.2 s old"));
  EXPECT_THAT(this->note(), HasSubstr("NTP"));
  base.begin(this->order(Kind::move, -2.0));
  EXPECT_THAT(this->note(), StartsWith("order is stamped 2.0 s ahead of this computer's clock"));
  BaseCommand first = this->order(Kind::move, 0.0);
  first.utime = Utime::from_us(1);
  base.begin(first);
  EXPECT_EQ(base.driver.status().command, Fate::refused);
}

TYPED_TEST(AnyBase, AnOldStopIsObeyedAndAnOldOrderChangesNothing) {
  auto& base = this->base_;
  const int64_t move = base.begin(this->order(Kind::move, 0.0));
  base.bench.run(0.4);
  ASSERT_TRUE(base.moves());
  base.begin(this->order(Kind::velocity, 10.0));
  base.bench.run(0.1);
  EXPECT_TRUE(base.moves());
  EXPECT_EQ(base.driver.status().command_id, move);
  EXPECT_EQ(base.driver.status().command, Fate::running);
  base.begin(this->order(Kind::stop, 1e8));
  base.bench.run(2.0);
  EXPECT_FALSE(base.moves());
  EXPECT_LT(base.way_m(), 0.35);
}

TYPED_TEST(AnyBase, NoRobotDrivesThat) {
  auto& base = this->base_;
  for (const double absurd : {1e308, -1e308, std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::quiet_NaN(), 1001.0}) {
    for (const Kind kind : kMotions) {
      BaseCommand command = this->order(kind, 0.0);
      command.distance_m = command.angle_rad = command.velocity_m_per_s = absurd;
      command.point_m = {absurd, 0.0};
      base.begin(command);
      EXPECT_EQ(base.driver.status().command, Fate::refused) << absurd;
      EXPECT_THAT(this->note(), HasSubstr("10 m/s")) << absurd;
    }
  }
  // Fields that the kind does not name are not read.
  BaseCommand command = this->order(Kind::turn, 0.0);
  command.velocity_m_per_s = 1e308;
  base.begin(command);
  EXPECT_EQ(base.driver.status().command, Fate::running);
}

TYPED_TEST(AnyBase, AnEmergencyStopHoldsUntilItIsReleased) {
  auto& base = this->base_;
  base.begin_move(3.0);
  base.bench.run(1.0);
  ASSERT_TRUE(base.moves());
  this->send(this->stop(true, 1e8));  // whatever its stamp
  EXPECT_TRUE(base.bench.run_until(0.15, [&] { return !base.moves(); }));
  base.bench.run(1.0);
  EXPECT_EQ(base.driver.status().command, Fate::aborted);
  EXPECT_EQ(this->note(), "emergency stop by sheriff: a child");
  for (const Kind kind : kMotions) {
    base.begin(this->order(kind, 0.0));
    EXPECT_EQ(base.driver.status().command, Fate::refused);
    EXPECT_THAT(this->note(), StartsWith("emergency stop by sheriff: a child; "));
    base.bench.run(0.5);
    EXPECT_FALSE(base.moves());
  }
  base.begin(this->order(Kind::stop, 0.0));
  base.bench.run(1.0);
  EXPECT_EQ(base.driver.status().command, Fate::done);
  this->send(this->stop(false));
  EXPECT_EQ(this->note(), "the emergency stop was released");
  base.bench.run(0.5);
  EXPECT_FALSE(base.moves());  // nothing of before is taken up again
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TYPED_TEST(AnyBase, DatagramsMayOvertakeEachOther) {
  auto& base = this->base_;
  const EmergencyStop first = this->stop(true), early_release = this->stop(false, 1.0);
  this->send(first);
  this->send(early_release);
  EXPECT_THAT(this->note(), HasSubstr("a release by sheriff is older"));
  base.bench.run(0.5);
  base.begin(this->order(Kind::move, 0.0));
  EXPECT_EQ(base.driver.status().command, Fate::refused);
  this->send(this->stop(false));
  this->send(first);  // the same datagram once more, late
  EXPECT_EQ(this->note(), "the emergency stop was released");
  // A clock that is a day ahead engages, and anybody's later release counts.
  base.bench.run(0.1);
  this->send(this->stop(true, -86400.0));
  EXPECT_THAT(this->note(), StartsWith(kEmergencyStopNote));
  base.bench.run(0.5);
  this->send(this->stop(false));
  EXPECT_EQ(base.move(0.2), Fate::done);
}

TYPED_TEST(AnyBase, AnEmergencyStopDropsTheOrderThatWaits) {
  auto& base = this->base_;
  base.begin_move(3.0);
  base.bench.run(0.8);
  base.begin(this->order(Kind::turn, 0.0));  // waits until the move has stopped
  this->send(this->stop(true));
  base.bench.run(1.0);
  this->send(this->stop(false));
  base.bench.run(1.0);
  EXPECT_FALSE(base.moves());
  EXPECT_NE(base.driver.status().command, Fate::running);
}

TYPED_TEST(AnyBase, AVelocityThatWaitedLongIsNotDrivenLonger) {
  auto& base = this->base_;
  base.begin_move(3.0);
  base.bench.run(0.8);
  base.velocity(0.1, 0.0);
  base.bench.frozen = true;
  base.bench.run(0.7);
  base.bench.frozen = false;
  base.bench.run(1.5);
  EXPECT_FALSE(base.moves());
  const double way_m = base.way_m();
  base.bench.run(1.0);
  EXPECT_EQ(base.way_m(), way_m);
}

// A guardian stops them. The driver may have hung while a packet was sent in part.
TYPED_TEST(AnyBase, StopBytesStopBehindAnyPartOfAPacket) {
  auto& base = this->base_;
  const auto drive = [&] {
    base.bench.frozen = false;
    return base.bench.run_until(3.0, [&] {
      base.velocity(0.1, 0.0);
      return base.moves();
    });
  };
  ASSERT_TRUE(drive());
  const auto packets = base.bench.sent_by_size;
  const std::vector<uint8_t> stop = base.driver.stop_bytes();
  for (const auto& [size, packet] : packets) {
    for (std::size_t part = 0; part < size; part += size < 16 ? 1 : 5) {
      ASSERT_TRUE(drive()) << size << " " << part;
      base.bench.frozen = true;
      base.bench.inject(std::span(packet).first(part));
      for (int i = 0; i < 3; ++i) {
        base.bench.inject(stop);
        base.bench.run(0.1);
      }
      EXPECT_FALSE(base.moves()) << part << " of " << size << " bytes";
    }
  }
}

TYPED_TEST(AnyBase, AfterAHangNothingResumes) {
  auto& base = this->base_;
  for (const Kind kind : {Kind::velocity, Kind::move}) {
    base.bench.run(1.0);
    base.begin(this->order(kind, 0.0));
    base.bench.run(0.4);
    ASSERT_TRUE(base.moves());
    base.begin(this->order(Kind::turn, 0.0));  // waits
    base.bench.frozen = true;
    for (int i = 0; i < 20; ++i) {
      base.bench.inject(base.driver.stop_bytes());
      base.bench.run(0.1);
    }
    EXPECT_FALSE(base.moves());
    base.bench.frozen = false;
    base.driver.on_hang(2.0, base.bench.host_now());
    base.bench.run(1.5);
    EXPECT_FALSE(base.moves());
    if (base.driver.status().link == BaseStatus::Link::up) {
      EXPECT_EQ(base.driver.status().command, Fate::aborted);
      EXPECT_EQ(this->note(), "the driver hung for 2.0 s: stopped");
    }
    ASSERT_TRUE(base.comes_up(4.0));
    EXPECT_EQ(base.move(0.2), Fate::done);
  }
}

// The driver is killed, stopped, or its cable cut.
template <class Base>
double stops_after_s(Base& base, double limit_s) {
  const Utime since = base.bench.now();
  EXPECT_TRUE(base.bench.run_until(limit_s, [&] { return !base.moves(); }));
  return (base.bench.now() - since).seconds();
}

TEST(Hcs12Runaway, TheWheelsStopByThemselvesWhenTheDriverDies) {
  for (const double when_s : {0.3, 0.9, 1.65, 2.0, 3.9}) {
    Hcs12 base;
    for (double t = 0.0; t < when_s; t += 0.05) {
      base.velocity(0.1, 0.0);
      base.bench.run(0.05);
    }
    ASSERT_TRUE(base.moves());
    base.bench.frozen = true;
    EXPECT_LT(stops_after_s(base, 5.0), hcs12::kVelocityRunS + 0.3) << when_s;
    const double way_m = base.way_m();
    base.bench.run(5.0);
    EXPECT_EQ(base.way_m(), way_m);
    base.bench.frozen = false;  // SIGCONT: nothing is taken up again
    base.bench.run(2.0);
    EXPECT_FALSE(base.moves());
    EXPECT_NEAR(base.driver.odom_from_robot().x_m, base.way_m(), 0.01 + 0.01 * base.way_m());
  }
}

TEST(Hcs12Runaway, ACutCableStopsAVelocityAndWhatWasDrivenIsCounted) {
  Hcs12 base;
  for (int i = 0; i < 24; ++i) {
    base.velocity(0.1, 0.0);
    base.bench.run(0.1);
  }
  const double before_m = base.driver.odom_from_robot().x_m;
  base.bench.plug(false);
  EXPECT_LT(stops_after_s(base, 5.0), hcs12::kVelocityRunS + 0.3);
  base.bench.plug(true);
  EXPECT_TRUE(base.comes_up(2.0));
  base.bench.run(1.0);
  EXPECT_GT(base.way_m(), before_m + 0.02);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, base.way_m(), 0.005);
}

// A board that falls silent is not a cut cable: the driver gives the link up by itself.
TEST(Hcs12Runaway, WhatWasDrivenWhileTheBoardWasSilentIsCounted) {
  Hcs12 base;
  base.speed(0.1);  // read in motion
  base.begin_move(0.3);
  base.bench.run(1.0);
  const double before_m = base.driver.odom_from_robot().x_m;
  base.bench.spoil = [](std::vector<uint8_t>& bytes) { bytes.clear(); };
  base.bench.deaf = true;
  ASSERT_TRUE(base.bench.run_until(
      4.0, [&] { return base.driver.status().link == BaseStatus::Link::down; }));
  base.bench.run(3.0);
  base.bench.spoil = nullptr;
  base.bench.deaf = false;
  EXPECT_TRUE(base.comes_up(2.0));
  base.bench.run(1.0);
  EXPECT_GT(base.way_m(), before_m + 0.1);
  EXPECT_LE(base.clicks_off(), 2.0);
}

TEST(Hcs12Runaway, NoLegOutlivesItsDriverForLong) {
  Hcs12 base;
  base.begin_move(20.0);
  base.bench.run(7.0);
  ASSERT_TRUE(base.moves());
  base.bench.frozen = true;
  // A piece of kLegRunS at top speed, and its ramps.
  EXPECT_LT(stops_after_s(base, 20.0), hcs12::kLegRunS + 1.5);
  EXPECT_LT(base.way_m(), 5.0);
}

TEST(Hcs12Runaway, ALongMoveIsDrivenInPiecesToItsEnd) {
  Hcs12 base;
  EXPECT_EQ(base.move(7.0), Fate::done);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, 7.0, 0.01);
  EXPECT_LE(base.clicks_off(), 4.0);
}

// Speeds over a tenth of a second, from when it has accelerated on. @returns the least by the mean.
double least_speed(Hcs12& base, double v, double w, double seconds) {
  std::vector<double> ways;
  for (double t = 0.0; t < seconds; t += 0.1) {
    base.velocity(v, w);
    const double before = base.board.left_clicks();
    base.bench.run(0.1);
    if (t > 0.45) ways.push_back(std::abs(base.board.left_clicks() - before));
  }
  double sum = 0.0;
  for (const double way : ways) sum += way;
  return *std::min_element(ways.begin(), ways.end()) / (sum / static_cast<double>(ways.size()));
}

TEST(Hcs12Runaway, ARenewedVelocityHasNoGap) {
  for (const double v : {0.04, 0.07, 0.1, 0.13}) {
    Hcs12 base;
    EXPECT_GT(least_speed(base, v, 0.0, 6.0), 0.4) << v;
    EXPECT_EQ(base.driver.timeouts(), 0);
    base.bench.run(1.5);
    // Between the last word of the counters and the next run's first the way is guessed.
    EXPECT_NEAR(base.driver.odom_from_robot().x_m, base.way_m(), 0.01 * base.way_m());
    EXPECT_NEAR(base.driver.odom_from_robot().theta_rad, 0.0, 0.03);
  }
  Hcs12 turning;
  EXPECT_GT(least_speed(turning, 0.0, 0.4, 6.0), 0.4);
}

TEST(Hcs12Runaway, AnotherSpeedTheSameWayNeedsNoStop) {
  Hcs12 base;
  for (int i = 0; i < 10; ++i) {
    base.velocity(0.05, 0.0);
    base.bench.run(0.1);
  }
  bool stood = false;
  auto remember = base.bench.each_step;
  base.bench.each_step = [&](Utime now) {
    remember(now);
    stood = stood || !base.board.motors_on();
  };
  const double before = base.board.left_clicks();
  for (int i = 0; i < 10; ++i) {
    base.velocity(0.12, 0.0);
    base.bench.run(0.1);
  }
  EXPECT_FALSE(stood);
  EXPECT_GT(base.board.left_clicks() - before, 5500.0);  // 1 s; at 0.05 m/s 3500
}

TEST(Hcs12Runaway, ARenewalWhoseAnswerIsLostStopsAndCounts) {
  Hcs12 base;
  bool eaten = false;
  double t = 0.0;
  base.bench.spoil = [&](std::vector<uint8_t>& bytes) {
    // The echo of the second `a`.
    if (eaten || t < 0.5 || bytes.empty() || bytes[0] != 'a') return;
    eaten = true;
    bytes.clear();
  };
  for (; t < 2.0; t += 0.1) {
    base.velocity(0.1, 0.0);
    base.bench.run(0.1);
  }
  EXPECT_TRUE(eaten);
  base.bench.run(1.5);
  EXPECT_FALSE(base.moves());
  EXPECT_EQ(base.driver.status().link, BaseStatus::Link::up);
  EXPECT_NEAR(base.driver.odom_from_robot().x_m, base.way_m(), 0.03);
}

TEST(PioneerRunaway, ItsWatchdogStopsItWhenTheDriverDies) {
  for (const bool cable : {false, true}) {
    Pioneer base;
    for (int i = 0; i < 10; ++i) {
      base.velocity(0.2, 0.0);
      base.bench.run(0.1);
    }
    if (cable) {
      base.bench.plug(false);
    } else {
      base.bench.frozen = true;
    }
    EXPECT_LT(stops_after_s(base, 9.0), 2.0 + 1.0);  // and 0.2 m/s braked by 0.3 m/s2
  }
}

TEST(PioneerRunaway, ARobotWithoutBumpersDrives) {
  p2os::P2osEmulatorOptions bare;
  bare.bumpers_each_end = 0;
  Pioneer base(bare);
  EXPECT_TRUE(base.driver.status().bumpers.empty());
  EXPECT_EQ(base.driver.status().note, "");
  EXPECT_EQ(base.move(0.3), Fate::done) << base.driver.status().note;
  EXPECT_EQ(base.move(-0.3), Fate::done) << base.driver.status().note;
}

TEST(PioneerRunaway, WhatItsOldFirmwareDoesNotTellIsSaid) {
  p2os::P2osEmulatorOptions old;
  old.tells_config = false;
  Pioneer base(old);
  EXPECT_THAT(base.driver.status().note, HasSubstr("assuming 5 at each end"));
  EXPECT_EQ(base.driver.status().bumpers.size(), 10U);
  EXPECT_EQ(base.move(0.3), Fate::done);
  old.bumpers_each_end = 0;
  Pioneer bare(old);
  EXPECT_EQ(bare.move(0.3), Fate::refused);
  EXPECT_EQ(bare.driver.status().note, "front bumpers 1 2 3 4 5 are pressed");
}

TEST(PioneerRunaway, AWatchdogThatIsOffIsSaid) {
  p2os::P2osEmulatorOptions options;
  options.watchdog_s = 0.0;
  p2os::P2osEmulator robot({}, options);
  p2os::P2osBase driver({});
  testing::Bench<p2os::P2osBase> bench(driver, robot, p2os::kBaud);
  EXPECT_TRUE(bench.run_until(3.0, [&] { return driver.status().link == BaseStatus::Link::up; }));
  EXPECT_THAT(driver.status().note, HasSubstr("watchdog is off"));
}

TEST(PanTiltOrders, OldOnesAreDroppedButAStopIsNot) {
  const Utime now = Utime::from_seconds(1e9);
  PanTiltCommand look;
  look.kind = PanTiltCommand::Kind::go_to;
  for (const double age_s : {0.6, 3e8, -0.6}) {
    look.utime = now - Duration::from_seconds(age_s);
    EXPECT_THROW(require_fresh(look, now), std::invalid_argument) << age_s;
  }
  look.utime = now - Duration::from_seconds(0.4);
  EXPECT_NO_THROW(require_fresh(look, now));
  EXPECT_NO_THROW(require_fresh(PanTiltCommand{}, now));
}

}  // namespace
}  // namespace marco::drivers
