#include <gmock/gmock.h>

#include "drivers/sick/driver.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::sick {
namespace {

using ::testing::HasSubstr;

struct Rig {
  explicit Rig(const SickOptions& options, SickEmulatorOptions device = {})
      : emulator(test_world, device), line(emulator), options_(options) {
    connect();
  }
  void connect() {
    driver.reset();
    stream.reset();
    stream = line.open({options_.baud});
    driver = std::make_unique<SickDriver>(*stream, options_, [this] { return line.now(); });
  }
  std::vector<ArrivedScan> run(double limit_s,
                               const std::function<bool(const std::vector<ArrivedScan>&)>& done) {
    return step_until(*driver, line, limit_s, done);
  }
  SickEmulator emulator;
  SimulatedLine line;
  SickOptions options_;
  std::unique_ptr<ByteStream> stream;
  std::unique_ptr<SickDriver> driver;
};

SickOptions at_baud(int baud) {
  SickOptions options;
  options.baud = baud;
  return options;
}

TEST(SickDriver, MeasuresInEveryVariantAndUnit) {
  struct Case {
    int angle_deg;
    double resolution_deg;
    const char* unit;
    int range_m;
    std::size_t beams;
  };
  for (const Case& one :
       {Case{180, 1.0, "mm", 8, 181}, Case{180, 0.5, "mm", 32, 361}, Case{100, 1.0, "cm", 80, 101},
        Case{100, 0.5, "mm", 16, 201}, Case{100, 0.25, "cm", 80, 401}}) {
    SickOptions options = at_baud(500'000);
    options.angle_deg = one.angle_deg;
    options.resolution_deg = one.resolution_deg;
    options.unit = one.unit;
    options.range_m = one.range_m;
    Rig rig(options);
    const auto scans = rig.run(4.0, have(5));
    ASSERT_GE(scans.size(), 5u) << rig.driver->state();
    for (const ArrivedScan& arrived : scans) {
      EXPECT_EQ(arrived.scan.size(), one.beams);
      // Half a unit of rounding, and 3.5 m/s of the test world's speed times 0.1 ms of timing.
      EXPECT_LT(worst_range_error_m(arrived.scan),
                (std::string(one.unit) == "mm" ? 0.0005 : 0.005) + 4e-4);
    }
    EXPECT_NEAR(scans[0].scan.bearing_rad(0), -one.angle_deg * 0.5 * 3.14159265 / 180.0, 1e-6);
    EXPECT_EQ(rig.emulator.configuration().unit(), one.unit[0] == 'm' ? Unit::mm : Unit::cm);
  }
}

TEST(SickDriver, FindsTheLaserAtAnySpeed) {
  for (const int device_baud : {9600, 19200, 38400, 500'000}) {
    for (const int wanted : {9600, 38400, 500'000}) {
      SickEmulatorOptions device;
      device.baud = device_baud;
      Rig rig(at_baud(wanted), device);
      const Utime start = rig.line.now();
      const auto scans = rig.run(8.0, have(1));
      ASSERT_EQ(scans.size(), 1u) << device_baud << " to " << wanted << rig.driver->state();
      // Five rates of 0.14 s, a settling of 0.25 s, ten requests, 0.3 s of writing, two scans.
      EXPECT_LT((rig.line.now() - start).seconds(), 4.0);
      EXPECT_EQ(rig.emulator.baud(), wanted);
    }
  }
}

TEST(SickDriver, StampsTheFirstBeamWhateverTheLineTakes) {
  for (const int baud : {9600, 38400, 500'000}) {
    Rig rig(at_baud(baud));
    const auto scans = rig.run(30.0, have(10));
    ASSERT_EQ(scans.size(), 10u);
    // Only the microseconds of rounding are left in simulated time.
    EXPECT_NEAR((scans.back().scan.utime - rig.emulator.last_first_beam()).seconds(), 0.0, 1e-4);
  }
}

TEST(SickDriver, DroppedScansAreNotMissedInTheTiming) {
  Rig rig(at_baud(9600));
  const auto scans = rig.run(30.0, have(10));
  ASSERT_EQ(scans.size(), 10u);
  EXPECT_GT(rig.emulator.scans_dropped(), 200);
  const double each_s = (scans[9].scan.utime - scans[0].scan.utime).seconds() / 9.0;
  EXPECT_NEAR(1.0 / each_s, 1.31, 0.05);  // thesis B's 732 bytes at 960 a second
}

TEST(SickDriver, FollowsAMirrorThatTurnsTooSlowly) {
  SickEmulatorOptions device;
  device.turn_s = 1.003 / 75.0;
  Rig rig(at_baud(500'000), device);
  double worst_s = 0.0;
  std::size_t seen = 0;
  rig.run(30.0, [&](const auto& scans) {
    if (scans.size() > std::max<std::size_t>(seen, 450)) {
      const double error_s = (scans.back().scan.utime - rig.emulator.last_first_beam()).seconds();
      worst_s = std::max(worst_s, std::abs(error_s));
    }
    seen = scans.size();
    return seen >= 600;
  });
  EXPECT_LT(worst_s, 2e-4);  // 0.3 % of two turns, which the nominal scan period does not know
}

TEST(SickDriver, InterlacedTurnsAreScansOfTheirOwn) {
  SickOptions options = at_baud(500'000);
  options.interlaced = true;
  Rig rig(options);
  const auto scans = rig.run(4.0, have(20));
  ASSERT_EQ(scans.size(), 20u);
  int shifted = 0;
  for (const ArrivedScan& arrived : scans) {
    EXPECT_THAT(arrived.scan.size(), ::testing::AnyOf(180u, 181u));
    EXPECT_LT(worst_range_error_m(arrived.scan), 0.0005 + 4e-4);
    shifted += arrived.scan.first_bearing_rad > -1.5708 + 0.008 ? 1 : 0;
  }
  EXPECT_EQ(shifted, 10);
  EXPECT_NEAR((scans[19].scan.utime - scans[1].scan.utime).seconds(), 18.0 / 75.0, 1e-3);
}

TEST(SickDriver, DoesNotWriteAConfigurationThatIsRightAlready) {
  Rig rig(at_baud(38400));
  rig.run(5.0, have(1));
  int configurations = 0;
  rig.line.set_tamper_to_device([&](Bytes& bytes) {
    configurations += bytes.size() > 4 && bytes[4] == kSetConfiguration ? 1 : 0;
  });
  rig.connect();
  EXPECT_EQ(rig.run(5.0, have(1)).size(), 1u);
  EXPECT_EQ(configurations, 0);
}

TEST(SickDriver, NoEchoAndDazzleAreNoRanges) {
  SickEmulator emulator(
      [](const LaserSweep& sweep) {
        std::vector<double> ranges_m(static_cast<std::size_t>(sweep.beams), 2.0);
        ranges_m[0] = std::numeric_limits<double>::infinity();
        ranges_m[1] = std::numeric_limits<double>::quiet_NaN();
        ranges_m[2] = 50.0;
        return ranges_m;
      },
      {});
  SimulatedLine line(emulator);
  SickOptions options = at_baud(38400);
  options.resolution_deg = 1.0;
  const auto stream = line.open({38400});
  SickDriver driver(*stream, options, [&] { return line.now(); });
  const auto scans = step_until(driver, line, 5.0, have(1));
  ASSERT_EQ(scans.size(), 1u);
  const std::vector<float>& ranges_m = scans[0].scan.ranges_m;
  EXPECT_GE(static_cast<double>(ranges_m[0]), driver.properties().range_max_m - 1e-5);
  EXPECT_EQ(ranges_m[1], 0.0f);
  EXPECT_GE(static_cast<double>(ranges_m[2]), driver.properties().range_max_m - 1e-5);
  EXPECT_FLOAT_EQ(ranges_m[3], 2.0f);
}

// ---- trouble -----------------------------------------------------------------------------------

TEST(SickDriver, IsBackAfterAResetInMidScan) {
  SickEmulatorOptions device;
  device.power_on_s = 5.0;
  Rig rig(at_baud(500'000), device);
  ASSERT_EQ(rig.run(6.0, have(3)).size(), 3u);
  rig.line.at(rig.line.now() + Duration::from_us(10'000),
              [&] { rig.emulator.power_cycle(rig.line.now()); });
  const Utime reset = rig.line.now();
  rig.run(2.0, [&](const auto&) { return !rig.driver->measuring(); });
  EXPECT_THAT(rig.driver->state(), HasSubstr("looking"));
  ASSERT_EQ(rig.run(15.0, have(1)).size(), 1u);
  // The device's own times: 5 s of power-on, 0.25 s of settling, replies, half a second of modes.
  EXPECT_LT((rig.line.now() - reset).seconds(), 5.0 + 1.2 + 1.0);
}

TEST(SickDriver, IsBackAfterThePlugWasOut) {
  Rig rig(at_baud(38400));
  ASSERT_EQ(rig.run(6.0, have(3)).size(), 3u);
  rig.line.at(rig.line.now() + Duration::from_us(100'000), [&] { rig.line.unplug(); });
  EXPECT_THROW(rig.run(2.0, have(1000)), StreamLost);
  rig.line.wait(Duration::from_us(3'000'000));
  rig.line.plug_in();
  rig.connect();
  const Utime back = rig.line.now();
  ASSERT_EQ(rig.run(6.0, have(1)).size(), 1u);
  EXPECT_LT((rig.line.now() - back).seconds(), 1.5);
}

TEST(SickDriver, SaysSoWhenTheLaserFallsSilentAndTakesItUpAgain) {
  Rig rig(at_baud(38400));
  ASSERT_EQ(rig.run(6.0, have(3)).size(), 3u);
  rig.line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  rig.run(3.0, [&](const auto&) { return !rig.driver->measuring(); });
  EXPECT_THAT(rig.driver->state(), HasSubstr("the scans stopped"));
  rig.run(5.0, have(1));
  rig.line.set_tamper_to_client({});
  const Utime back = rig.line.now();
  ASSERT_EQ(rig.run(6.0, have(1)).size(), 1u);
  EXPECT_LT((rig.line.now() - back).seconds(), 2.0 + 1.0);
}

TEST(SickDriver, IsNotMovedByAFloodOfGarbage) {
  Rig rig(at_baud(500'000));
  ASSERT_EQ(rig.run(6.0, have(3)).size(), 3u);
  std::mt19937 random(2);
  rig.line.set_tamper_to_client([&](Bytes& bytes) {
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  });
  EXPECT_TRUE(rig.run(3.0, have(1)).empty());
  EXPECT_FALSE(rig.driver->measuring());
  EXPECT_GT(rig.driver->counts().garbage_bytes, 1000);
  rig.line.set_tamper_to_client({});
  ASSERT_EQ(rig.run(6.0, have(1)).size(), 1u);
}

TEST(SickDriver, PublishesNothingWithABadChecksum) {
  Rig rig(at_baud(500'000));
  ASSERT_EQ(rig.run(6.0, have(3)).size(), 3u);
  std::mt19937 random(4);
  rig.line.set_tamper_to_client([&](Bytes& bytes) {
    if (random() % 40 == 0) bytes[random() % bytes.size()] ^= 0x10;
  });
  const auto scans = rig.run(5.0, have(10'000));
  EXPECT_GT(scans.size(), 50u);
  EXPECT_GT(rig.driver->counts().drops.at("bad_checksum"), 5);
  for (const ArrivedScan& arrived : scans) {
    EXPECT_LT(worst_range_error_m(arrived.scan), 0.0005 + 4e-4);
  }
}

TEST(SickDriver, SaysThatTheWindowIsDirtyAndThatThePasswordIsWrong) {
  SickEmulatorOptions device;
  device.polluted = true;
  Rig rig(at_baud(38400), device);
  rig.run(6.0, have(1));
  EXPECT_THAT(rig.driver->state(), HasSubstr("pollution"));
  SickOptions options = at_baud(38400);
  options.password = "sesame!!";
  Rig locked(options);
  locked.run(3.0, have(1));
  EXPECT_THAT(locked.driver->state(), HasSubstr("refused the password"));
}

TEST(SickDriver, RefusesWhatTheLaserHasNot) {
  SickEmulator emulator(test_world, {});
  SimulatedLine line(emulator);
  const auto stream = line.open({9600});
  const auto refuses = [&](const std::function<void(SickOptions&)>& change) {
    SickOptions options;
    change(options);
    EXPECT_THROW(SickDriver(*stream, options, [&] { return line.now(); }), std::invalid_argument);
  };
  refuses([](SickOptions& options) { options.resolution_deg = 0.25; });
  refuses([](SickOptions& options) { options.baud = 57600; });
  refuses([](SickOptions& options) { options.unit = "m"; });
  refuses([](SickOptions& options) { options.range_m = 80; });
  refuses([](SickOptions& options) { options.password = "short"; });
}

}  // namespace
}  // namespace marco::drivers::sick
