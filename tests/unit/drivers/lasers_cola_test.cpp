#include <gmock/gmock.h>

#include <string>

#include "common/pose2.hpp"
#include "drivers/cola/driver.hpp"
#include "simulator/devices/cola/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::cola {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

// Printed in SICK's listing for an LMS111.
const std::string kListed =
    "sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 "
    "3F800000 00000000 186A0 1388 15 8A1 8A5 8AB 8AC 8A6 8AC 8B6 8C8 8C2 8C9 8CB 8C4 8E4 8E1 8EB "
    "8E0 8F5 908 8FC 907 906 0 0 0 0 0 0";

TEST(ColaCodec, ListedScan) {
  const auto scan = decode_scan(kListed);
  ASSERT_TRUE(scan.has_value());
  EXPECT_EQ(scan->serial, 0x89A27Fu);
  EXPECT_EQ(scan->telegrams, 835u);
  EXPECT_EQ(scan->scans, 839u);
  EXPECT_EQ(scan->sent_us - scan->begin_us, 1426u);
  EXPECT_EQ(scan->outputs, 7u);
  EXPECT_EQ(scan->rate_chz, 5000u);
  EXPECT_EQ(scan->sample_rate, 360u);
  const Channel* ranges = scan->channel("DIST1");
  ASSERT_NE(ranges, nullptr);
  EXPECT_EQ(ranges->start_e4, 100'000);
  EXPECT_EQ(ranges->step_e4, 5000);
  ASSERT_EQ(ranges->values.size(), 21u);
  EXPECT_EQ(ranges->values.front(), 2209);
  EXPECT_EQ(ranges->values.back(), 2310);
  EXPECT_EQ(scan->channel("RSSI1"), nullptr);
}

TEST(ColaCodec, EveryFieldReadsAsItWasWritten) {
  ScanData scan;
  scan.status = 5;
  scan.inputs = 3;
  scan.begin_us = 0xFFFFFFF0u;
  scan.sent_us = 20;
  scan.rate_chz = 1500;
  scan.encoders = {{7, 8}, {9, 10}};
  scan.wide = {{"DIST1", 2.0, -5.0, -450'000, 3333, {0, 16, 65'535}},
               {"DIST2", 1.0, 0.0, -450'000, 3333, {}}};
  scan.narrow = {{"RSSI1", 1.0, 0.0, -450'000, 3333, {0, 255}}};
  scan.name = "not defined";
  scan.comment = "by the door";
  scan.time = {2026, 11, 25, 12, 0, 1, 999'999};
  const std::string text = encode_scan(scan, "sSN");
  EXPECT_EQ(decode_scan(text), scan) << text;
  EXPECT_EQ(scan.channel("DIST1")->scaled(1), 27.0);
  // A TiM's angles, behind a sign or not.
  EXPECT_THAT(text, HasSubstr("DIST1 40000000 C0A00000 FFF92230 D05 3 0 10 FFFF"));
  std::string decimal = text;
  decimal.replace(decimal.find("FFF92230"), 8, "-450000");
  EXPECT_EQ(decode_scan(decimal), scan);
}

TEST(ColaCodec, WhatIsNotWholeIsNoScan) {
  // Up to the last value; what stands behind the values may be missing.
  const std::size_t whole = kListed.size() - std::string(" 0 0 0 0 0 0").size();
  for (std::size_t length = 0; length < whole - 3; ++length) {
    EXPECT_FALSE(decode_scan(kListed.substr(0, length)).has_value()) << length;
  }
  EXPECT_FALSE(decode_scan("sRA DeviceIdent 6 TiM561").has_value());
  std::string wrong = kListed;
  wrong.replace(wrong.find(" 15 8A1"), 3, " FFFFF");  // more values than there are
  EXPECT_FALSE(decode_scan(wrong).has_value());
  wrong = kListed;
  wrong.replace(wrong.find("8A1"), 3, "10000");  // more than 16 bits
  EXPECT_FALSE(decode_scan(wrong).has_value());
  wrong.replace(wrong.find("3F800000"), 8, "7F800000");  // infinite
  EXPECT_FALSE(decode_scan(wrong).has_value());
}

TEST(ColaParser, FindsTelegramsAgainAfterDamage) {
  const auto texts = [](const std::vector<Bytes>& chunks) {
    TelegramParser parser;
    std::vector<std::string> found;
    for (const Bytes& chunk : chunks) {
      parser.push(chunk);
      while (const auto telegram = parser.next()) found.push_back(telegram->text);
    }
    return found;
  };
  const Bytes first = encode_telegram("sRN DeviceIdent"), second = encode_telegram(kListed);
  std::mt19937 random(3);
  EXPECT_THAT(texts(split_at_random(join({first, second, first}), random)),
              ::testing::ElementsAre("sRN DeviceIdent", kListed, "sRN DeviceIdent"));
  for (std::size_t cut = 0; cut < second.size(); ++cut) {
    const Bytes part(second.begin(), second.begin() + static_cast<std::ptrdiff_t>(cut));
    EXPECT_THAT(texts(split_at_random(join({part, first}), random)),
                ::testing::ElementsAre("sRN DeviceIdent"))
        << cut;
  }
  EXPECT_THAT(texts({hex("00 FF 03 02 80 03"), first}), ::testing::SizeIs(1));
  TelegramParser parser;
  parser.push(Bytes(100'000, 'x'));
  parser.push(encode_telegram(std::string(kMostText + 1, 'y')));  // no memory without end
  parser.push(first);
  const auto telegram = parser.next();
  ASSERT_TRUE(telegram.has_value());
  EXPECT_EQ(telegram->text, "sRN DeviceIdent");
  EXPECT_GT(parser.garbage_bytes(), 165'000);
}

// A busy machine halts the simulator, not the mirror that it simulates.
TEST(ColaEmulator, SendsTheTurnsOfAHaltAfterwards) {
  ColaEmulator emulator(test_world, tim551());
  const Utime start = Utime::from_us(1'000'000);
  emulator.on_connection(true, start);
  Bytes sent;
  const auto ask = [&](const std::string& text, Utime now) {
    emulator.receive(encode_telegram(text), 0, now);
    emulator.advance(now + Duration::from_seconds(0.05), sent);
  };
  ask("sEN LMDscandata 1", start);
  const Utime before = start + Duration::from_seconds(1.0);
  emulator.advance(before, sent);
  emulator.advance(before + Duration::from_seconds(2.0), sent);
  // Who logs in halts it, and the turns of that time are not sent later.
  ask("sMN SetAccessMode 03 F4724744", before + Duration::from_seconds(2.0));
  ask("sMN Run", before + Duration::from_seconds(12.0));
  emulator.advance(before + Duration::from_seconds(13.0), sent);
  TelegramParser parser;
  parser.push(sent);
  int scans = 0;
  while (const auto telegram = parser.next()) scans += telegram->text.starts_with("sSN") ? 1 : 0;
  EXPECT_NEAR(scans, 4 * 15, 3);
}

struct Rig {
  explicit Rig(const ColaOptions& options = {},
               const ColaEmulatorOptions& device = {},
               LaserWorld world = test_world)
      : emulator(std::move(world), device),
        line(emulator, false),
        stream(line.open({})),
        driver(*stream, options, [this] { return line.now(); }) {}
  std::vector<ArrivedScan> run(double limit_s, std::size_t count) {
    return step_until(driver, line, limit_s, have(count));
  }
  ColaEmulator emulator;
  SimulatedLine line;
  std::unique_ptr<ByteStream> stream;
  ColaDriver driver;
};

// Ranges are rounded to 1 mm, the world moves by 3.5 m/s: 0.3 ms of timing make 1 mm.
constexpr double kToleranceM = 0.0005 + 0.001;

TEST(ColaDriver, MeasuresAsTheModelDoes) {
  for (const auto& [device, range_max_m] : {std::pair{ColaEmulatorOptions{}, 10.0},
                                            std::pair{tim551(), 10.0}, std::pair{lms111(), 20.0}}) {
    Rig rig({}, device);
    const auto scans = rig.run(60.0, 400);  // the laser's clock wraps
    ASSERT_EQ(scans.size(), 400u) << rig.driver.state();
    for (const ArrivedScan& arrived : scans) {
      ASSERT_EQ(arrived.scan.size(), static_cast<std::size_t>(device.beams));
      EXPECT_NEAR(arrived.scan.first_bearing_rad, deg_to_rad(-135.0), 1e-9);
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << device.model;
      EXPECT_TRUE(arrived.intensities.empty());
    }
    EXPECT_NEAR((scans.back().scan.utime - scans.front().scan.utime).seconds(),
                399.0 / device.turns_per_s, 0.001);
    EXPECT_EQ(rig.driver.properties().range_max_m, range_max_m);
    EXPECT_THAT(rig.driver.state(), HasSubstr("measuring"));
    EXPECT_THAT(rig.driver.state(), HasSubstr(device.model));
    EXPECT_EQ(rig.driver.counts().dropped(), 0);
    rig.driver.stop();
    rig.line.wait(Duration::from_seconds(0.1));
    EXPECT_FALSE(rig.emulator.streaming());
  }
}

TEST(ColaDriver, NoEchoAndCodesAreNoReturn) {
  const LaserWorld nothing = [](const LaserSweep& sweep) {
    std::vector<double> ranges_m(static_cast<std::size_t>(sweep.beams), HUGE_VAL);
    ranges_m[5] = 0.015;  // 15 is a code
    ranges_m[6] = 0.016;
    return ranges_m;
  };
  Rig rig({}, {}, nothing);
  const auto scans = rig.run(5.0, 1);
  ASSERT_EQ(scans.size(), 1u);
  LaserScan scan = scans[0].scan;
  EXPECT_FLOAT_EQ(scan.ranges_m[6], 0.016F);
  scan.ranges_m[6] = 0.0F;
  EXPECT_THAT(scan.ranges_m, Each(0.0F));
}

TEST(ColaDriver, IntensitiesWhenAskedFor) {
  ColaOptions options;
  options.intensities = true;
  ColaEmulatorOptions refuses;
  refuses.login = false;
  for (const auto& device : {ColaEmulatorOptions{}, lms111(), refuses}) {
    Rig rig(options, device);
    const auto scans = rig.run(10.0, 3);
    ASSERT_EQ(scans.size(), 3u) << rig.driver.state();
    ASSERT_EQ(scans[2].intensities.size(), scans[2].scan.size());
    const double range_m = static_cast<double>(scans[2].scan.ranges_m[100]);
    EXPECT_NEAR(static_cast<double>(scans[2].intensities[100]), 250.0 / (1.0 + range_m), 1.1);
  }
}

TEST(ColaDriver, SaysWhatTheLaserSays) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 3).size(), 3u);
  EXPECT_THAT(rig.driver.state(), Not(HasSubstr("window")));
  rig.emulator.set_status(2);
  ASSERT_EQ(rig.run(5.0, 3).size(), 3u);
  EXPECT_THAT(rig.driver.state(), HasSubstr("the laser's window is dirty"));
  rig.emulator.set_status(1);
  ASSERT_EQ(rig.run(5.0, 3).size(), 3u);
  EXPECT_THAT(rig.driver.state(), HasSubstr("the laser reports an error"));

  rig.emulator.power_cycle(rig.line.now());
  std::string seen;
  step_until(rig.driver, rig.line, 10.0, [&](const auto& scans) {
    seen += rig.driver.state() + "\n";
    return !scans.empty();
  });
  EXPECT_THAT(seen, HasSubstr("the scans stopped"));
  EXPECT_THAT(seen, HasSubstr("the laser is not ready yet"));
  EXPECT_THAT(rig.driver.state(), Not(HasSubstr("not ready")));
}

TEST(ColaDriver, KnowsTheBinaryDialect) {
  ColaEmulatorOptions device;
  device.binary = true;
  Rig rig({}, device);
  EXPECT_TRUE(rig.run(5.0, 1).empty());
  EXPECT_THAT(rig.driver.state(), HasSubstr("looking for the laser"));
  EXPECT_THAT(rig.driver.state(), HasSubstr("it speaks CoLa B"));
}

// Some lasers tell a sample rate that is a hundred times too large, or stamps that stand still.
TEST(ColaAssembler, TimesOfBeamsAreOfTheRateAndTheStep) {
  ScanData data = *decode_scan(kListed);
  data.sample_rate *= 100;
  ScanAssembler assembler;
  const Utime arrival = Utime::from_us(1'000'000'000'000);
  assembler.add(data, arrival);
  const auto scans = assembler.take_scans();
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_NEAR(static_cast<double>(scans[0].scan.time_offsets_s.back()), 20 * 0.5 / 360.0 / 50.0,
              1e-9);
  EXPECT_EQ((arrival - scans[0].scan.utime).us, 1426);
  data.begin_us = data.sent_us;  // as if it were sent before it was measured
  assembler.restart_clock();
  assembler.add(data, arrival);
  EXPECT_NEAR((arrival - assembler.take_scans()[0].scan.utime).seconds(), 20 * 0.5 / 360.0 / 50.0,
              2e-6);
  data.rate_chz = 0;
  assembler.add(data, arrival);
  EXPECT_TRUE(assembler.take_scans().empty());
  EXPECT_EQ(assembler.counts().drops.at("inconsistent"), 1);
}

}  // namespace
}  // namespace marco::drivers::cola
