#include <gmock/gmock.h>

#include "drivers/sick/driver.hpp"
#include "drivers/sick/emulator.hpp"
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
  EXPECT_GE(static_cast<double>(ranges_m[0]), driver.sight().range_max_m - 1e-5);
  EXPECT_EQ(ranges_m[1], 0.0f);
  EXPECT_GE(static_cast<double>(ranges_m[2]), driver.sight().range_max_m - 1e-5);
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
  EXPECT_THAT(rig.driver->state(), HasSubstr("no scans came any more"));
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

// ---- the emulator as other hosts meet it
// ---------------------------------------------------------

Bytes answer_to(SickEmulator& emulator, Utime& now, const Bytes& request, int baud = 9600) {
  Bytes out;
  for (const uint8_t byte : request) emulator.receive({&byte, 1}, baud, now);
  for (int i = 0; i < 400; ++i) {
    now = now + Duration::from_us(1000);
    emulator.advance(now, out);
  }
  return out;
}

TEST(SickEmulator, AcknowledgesRefusesAndRejects) {
  SickEmulator emulator(test_world, {});
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  const auto expect = [&](const Bytes& request, const char* answer) {
    EXPECT_EQ(answer_to(emulator, now, request), hex(answer));
  };
  expect(set_mode_request(kOnRequest), "06 02 80 03 00 A0 00 10 16 0A");
  expect(set_variant_request(180, 25), "06 02 80 07 00 BB 00 B4 00 19 00 10 8F DB");
  expect(installation_request("SICK_PLS"), "06 02 80 03 00 A0 01 10 14 0B");
  expect(set_configuration_request({}), "06 02 80 02 00 92 10 7F 33");  // not in installation mode
  expect(encode_request(Bytes{0x66}), "06 02 80 02 00 92 10 7F 33");
  expect(hex("02 00 02 00 20 25 35 09"), "15");
  expect(hex("02"), "");  // a lone beginning, and then the telegram
  EXPECT_EQ(answer_to(emulator, now, encode_request(Bytes{kGetErrors}), 38400), Bytes{});
}

TEST(SickEmulator, ChangesItsSpeedAfterTheReply) {
  SickEmulator emulator(test_world, {});
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  EXPECT_EQ(answer_to(emulator, now, set_mode_request(kBaud38400)),
            hex("06 02 80 03 00 A0 00 10 16 0A"));
  EXPECT_EQ(emulator.baud(), 38400);
  EXPECT_EQ(answer_to(emulator, now, set_mode_request(kOnRequest), 38400),
            hex("06 02 80 03 00 A0 00 10 16 0A"));
  EXPECT_EQ(answer_to(emulator, now, encode_request(Bytes{kReset}), 38400),
            hex("06 02 80 02 00 91 10 79 30"));
}

TEST(SickEmulator, GivesOneScanOnRequestAndSubRanges) {
  SickEmulator emulator(test_world, {});
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  answer_to(emulator, now, set_variant_request(100, 100));
  const Bytes scan = answer_to(emulator, now, encode_request(Bytes{kGetValues, 1}));
  EXPECT_EQ(scan.size(), 1u + 10 + 2 * 101);
  const Bytes some =
      answer_to(emulator, now, encode_request(Bytes{kSetMode, kSubRange, 2, 0, 4, 0}));
  TelegramParser parser(TelegramParser::Side::laser);
  parser.push(some);
  int found = 0;
  while (const auto event = parser.next()) {
    if (event->kind != Event::Kind::telegram || event->code() != kSubRangeReply) continue;
    const auto values = decode_values(*event).value();
    EXPECT_EQ(values.words.size(), 3u);
    ++found;
  }
  EXPECT_GT(found, 5);
}

std::vector<MeasuredValues> values_in(const Bytes& bytes) {
  TelegramParser parser(TelegramParser::Side::laser);
  parser.push(bytes);
  std::vector<MeasuredValues> found;
  while (const auto event = parser.next()) {
    if (event->kind != Event::Kind::telegram || !carries_values(event->code())) continue;
    if (const auto values = decode_values(*event)) found.push_back(*values);
  }
  return found;
}

TEST(SickEmulator, StreamsMeansPartsAndReflectivities) {
  SickEmulatorOptions fast;
  fast.type = "LMS291;S14;X01.27";
  fast.baud = 500'000;
  SickEmulator emulator(test_world, fast);
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  const auto ask = [&](const Bytes& payload) {
    return answer_to(emulator, now, encode_request(payload), 500'000);
  };
  ask(Bytes{kSetVariant, 180, 0, 100, 0});
  const auto means = values_in(ask(Bytes{kSetMode, kMean, 5}));
  ASSERT_GE(means.size(), 3u);  // 0.4 s of 13.3 ms turns, five a mean, less the mode change
  EXPECT_LE(means.size(), 6u);
  EXPECT_EQ(means[0].samples, 5);
  ASSERT_EQ(means[0].words.size(), 181u);
  // A mean of five turns lies within what the range did meanwhile: 3.5 m/s for 67 ms, in cm.
  const double half_way_s = now.seconds() - 0.4 + 0.1;
  EXPECT_NEAR(means[0].words[90], 100.0 * test_range_m(0.0, half_way_s), 30.0);
  const auto parts = values_in(ask(Bytes{kSetMode, kMeanSubRange, 2, 11, 0, 20, 0}));
  ASSERT_GE(parts.size(), 5u);
  EXPECT_EQ(parts.back().samples, 2);
  EXPECT_EQ(parts.back().sub_range.value()[1], 20);
  EXPECT_EQ(parts.back().words.size(), 10u);
  const auto bright = values_in(ask(Bytes{kSetMode, kReflectivity, 1, 0, 181, 0}));
  ASSERT_GE(bright.size(), 5u);
  EXPECT_EQ(bright.back().words.size(), 181u);
  EXPECT_EQ(bright.back().reflectivity.size(), 181u);
  EXPECT_GT(bright.back().reflectivity[90], 100);
  ask(Bytes{kSetMode, kOnRequest});
  EXPECT_EQ(values_in(ask(Bytes{kGetMean, 3})).at(0).samples, 3);
  EXPECT_EQ(values_in(ask(Bytes{kGetSubRange, 5, 0, 6, 0})).at(0).words.size(), 2u);
  EXPECT_EQ(values_in(ask(Bytes{kGetMeanSubRange, 3, 5, 0, 6, 0})).size(), 1u);
}

TEST(SickEmulator, RefusesModesThatItHasNot) {
  SickEmulator emulator(test_world, {});
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  const auto answer = [&](const Bytes& payload) {
    return answer_to(emulator, now, encode_request(payload));
  };
  const Bytes refused = hex("06 02 80 03 00 A0 01 10 14 0B");
  EXPECT_EQ(answer(Bytes{kSetMode, kMean}), refused);  // of how many?
  EXPECT_EQ(answer(Bytes{kSetMode, kMean, 1}), refused);
  EXPECT_EQ(answer(Bytes{kSetMode, kSubRange, 0, 0, 9, 0}), refused);
  EXPECT_EQ(answer(Bytes{kSetMode, kSubRange, 1, 0, 0x6A, 1}), refused);   // 362 of 361
  EXPECT_EQ(answer(Bytes{kSetMode, kReflectivity, 1, 0, 9, 0}), refused);  // no fast model
  for (const int mode : {0x20, 0x21, 0x22, 0x23, 0x29, 0x2B, 0x2C, 0x2E}) {
    EXPECT_EQ(answer(Bytes{kSetMode, static_cast<uint8_t>(mode)}), refused) << mode;
  }
  EXPECT_EQ(answer(Bytes{kSetMode, kDiagnosis}), hex("06 02 80 03 00 A0 00 10 16 0A"));
  EXPECT_EQ(answer(Bytes{kGetMean, 3}), hex("06 02 80 02 00 92 10 7F 33"));  // in diagnosis
}

TEST(SickEmulator, TellsItsStateInFull) {
  SickEmulatorOptions dirty;
  dirty.polluted = true;
  SickEmulator emulator(test_world, dirty);
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  TelegramParser parser(TelegramParser::Side::laser);
  parser.push(answer_to(emulator, now, encode_request(Bytes{kGetStatus})));
  parser.next();  // the ACK
  const StatusReport report = decode_status(parser.next().value()).value();
  EXPECT_EQ(report.motor_revolutions, 4500);
  EXPECT_LT(report.pollution[7], report.pollution_calibration[7]);
  EXPECT_EQ(report.reference_pollution, report.reference_calibration);
  EXPECT_TRUE(report.laser_on);
  EXPECT_EQ(report.variant_type, 1);
  parser.push(answer_to(emulator, now, encode_request(Bytes{kGetErrors})));
  parser.next();
  EXPECT_EQ(parser.next()->data().size(), 2u);
}

}  // namespace
}  // namespace marco::drivers::sick
