#include <gmock/gmock.h>

#include <numbers>

#include "drivers/hokuyo/driver.hpp"
#include "simulator/devices/hokuyo/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::hokuyo {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Bytes ascii(const std::string& text) { return {text.begin(), text.end()}; }

std::vector<Reply> replies_in(const std::vector<Bytes>& chunks) {
  ReplyParser parser;
  std::vector<Reply> replies;
  for (const Bytes& chunk : chunks) {
    parser.push(chunk);
    while (const auto reply = parser.next()) replies.push_back(*reply);
  }
  return replies;
}

TEST(Scip, NumbersAndSums) {
  EXPECT_EQ(encode_number(1234, 2), "CB");
  EXPECT_EQ(encode_number(5432, 3), "1Dh");
  EXPECT_EQ(encode_number(16'000'000, 4), "m2@0");
  EXPECT_EQ(decode_number("CB"), 1234u);
  EXPECT_EQ(decode_number("1Dh"), 5432u);
  EXPECT_EQ(decode_number("m2@0"), 16'000'000u);
  EXPECT_EQ(decode_number("m\x7F@0"), std::nullopt);
  const char* statuses[][2] = {{"00", "P"}, {"99", "b"}, {"0E", "e"},
                               {"02", "R"}, {"03", "S"}, {"04", "T"}};
  for (const auto& [status, sum] : statuses) EXPECT_EQ(checksum(status), sum[0]);
}

TEST(Scip, VectorsBothWays) {
  EXPECT_EQ(encode_reply({"BM", "00", {}}), ascii("BM\n00P\n\n"));
  EXPECT_EQ(encode_reply({"QT", "00", {}}), ascii("QT\n00P\n\n"));
  const ScanRequest request{true, 3, 44, 48, 1, 0, 0};
  const Measurement scan{16'000'000, {1000, 1001, 1002, 1003, 20}, {}};
  const Bytes line = ascii("MD0044004801000\n99b\nm2@0?\n0?X0?Y0?Z0?[00D6\n\n");
  EXPECT_EQ(encode_reply(encode_measurement(request, 0, scan)), line);
  const auto replies = replies_in({line});
  ASSERT_EQ(replies.size(), 1u);
  const auto read = decode_measurement(replies[0], request);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->timestamp_ms, scan.timestamp_ms);
  EXPECT_EQ(read->values_mm, scan.values_mm);
}

TEST(Scip, ParameterLines) {
  const Bytes lines = encode_reply(encode_parameters({}));
  const std::string text(lines.begin(), lines.end());
  for (const char* line :
       {"DMIN:20;4", "DMAX:5600;_", "ARES:1024;\\", "AMIN:44;7", "AMAX:725;o", "AFRT:384;6",
        "SCAN:600;e", "MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N"}) {
    EXPECT_THAT(text, HasSubstr(std::string(line) + "\n"));
  }
  EXPECT_EQ(decode_parameters(replies_in({lines})[0])->last_step, 725);
  // With the semicolon in the sum, as other devices write.
  std::string other = "PP\n00P\n";
  for (std::string key : {"DMIN:20;", "DMAX:5600;", "ARES:1024;", "AMIN:44;", "AMAX:725;",
                          "AFRT:384;", "SCAN:600;"}) {
    other += key + checksum(key) + "\n";
  }
  EXPECT_EQ(decode_parameters(replies_in({ascii(other + "\n")})[0])->front_step, 384);
}

// ';' is 0Bh + 30h, a character of the data like any other: a line of data that ends in it is
// summed with it. The maker's library drops a scan with another sum.
TEST(Scip, ASemicolonInTheDataIsData) {
  const ScanRequest request{true, 3, 44, 48, 1, 0, 0};
  const Measurement scan{16'000'000, {1000, 1001, 1002, 1003, 11}, {}};
  const std::string line = "MD0044004801000\n99b\nm2@0?\n0?X0?Y0?Z0?[00;?\n\n";
  unsigned sum = 0;
  for (const char c : std::string("0?X0?Y0?Z0?[00;")) sum += static_cast<unsigned char>(c);
  std::string right = line;
  right[right.size() - 3] = static_cast<char>((sum & 0x3F) + 0x30);
  EXPECT_EQ(encode_reply(encode_measurement(request, 0, scan)), ascii(right));
  EXPECT_EQ(replies_in({ascii(right)}).size(), 1u);
  // The sum of the data without it fits no line but a key line's.
  std::string wrong = right;
  wrong[wrong.size() - 3] = static_cast<char>(((sum - ';') & 0x3F) + 0x30);
  EXPECT_TRUE(replies_in({ascii(wrong)}).empty());
}

TEST(Scip, ReadsScanRequests) {
  const auto request = parse_scan_request("MS0044072502312");
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->characters, 2);
  EXPECT_EQ(request->cluster, 2);
  EXPECT_EQ(request->skip, 3);
  EXPECT_EQ(request->count, 12);
  EXPECT_EQ(request->values(), 341);
  EXPECT_EQ(request->line(), "MS0044072502312");
  EXPECT_EQ(parse_scan_request("GD0044072501")->line(), "GD0044072501");
  EXPECT_FALSE(parse_scan_request("MD004407250100").has_value());
  EXPECT_FALSE(parse_scan_request("MD00x4072501000").has_value());
  EXPECT_FALSE(parse_scan_request("MD0725004401000").has_value());
}

Bytes with_stamp(const Measurement& scan) {
  Bytes message = ascii(encode_number(scan.timestamp_ms, 4));
  for (const uint32_t value : scan.values_mm) {
    for (const char c : encode_number(value, 3)) message.push_back(static_cast<uint8_t>(c));
  }
  return message;
}

TEST(Scip, FindsAnyScansInAnySplitAndResynchronizes) {
  const ScanRequest request{true, 3, 0, 149, 1, 0, 0};
  std::mt19937 random(6);
  std::vector<Bytes> telegrams;
  std::vector<Bytes> messages;
  for (uint32_t i = 0; i < 8; ++i) {
    Measurement scan{i * 100, {}, {}};
    for (int k = 0; k < 150; ++k) scan.values_mm.push_back(random() % 262'144);
    telegrams.push_back(encode_reply(encode_measurement(request, 0, scan)));
    messages.push_back(with_stamp(scan));
  }
  const auto parse = [&](const std::vector<Bytes>& chunks) {
    std::vector<Bytes> found;
    for (const Reply& reply : replies_in(chunks)) {
      if (const auto scan = decode_measurement(reply, request)) found.push_back(with_stamp(*scan));
    }
    return found;
  };
  EXPECT_EQ(parse(split_at_random(join(telegrams), random)), messages);
  expect_resynchronizes(telegrams, messages, parse, 400);
}

TEST(Scip, CountsWhatItDrops) {
  ReplyParser parser;
  parser.push(ascii("BM\n00Q\n\nnoise\n\nQT\n00P\n\n"));
  const auto reply = parser.next();
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(reply->echo, "QT");
  EXPECT_EQ(parser.bad_checksums(), 1);
  EXPECT_EQ(parser.garbage_bytes(), 8 + 7);
}

struct Rig {
  explicit Rig(HokuyoEmulatorOptions device = {}, HokuyoOptions options = {})
      : emulator(test_world, device), line(emulator), options_(options) {
    connect();
  }
  void connect() {
    driver.reset();
    stream.reset();
    stream = line.open({});
    driver = std::make_unique<HokuyoDriver>(*stream, options_, [this] { return line.now(); });
  }
  std::vector<ArrivedScan> run(double limit_s, std::size_t count) {
    return step_until(*driver, line, limit_s, have(count));
  }
  HokuyoEmulator emulator;
  SimulatedLine line;
  HokuyoOptions options_;
  std::unique_ptr<ByteStream> stream;
  std::unique_ptr<HokuyoDriver> driver;
};

// Half a millimetre of rounding and 3.5 m/s of the test world's speed times the millisecond to
// which the laser's stamps are cut.
constexpr double kToleranceM = 0.0005 + 0.0035;

double worst_error_m(const ArrivedScan& arrived, double beam_interval_s) {
  LaserScan scan = arrived.scan;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    scan.time_offsets_s.push_back(static_cast<float>(beam_interval_s * static_cast<double>(i)));
  }
  return worst_range_error_m(scan);
}

TEST(HokuyoDriver, MeasuresWithEachModel) {
  for (const char* model : {"URG-04LX", "UTM-30LX", "UST-10LX"}) {
    HokuyoEmulatorOptions device;
    device.model = model;
    Rig rig(device);
    const Parameters parameters = parameters_of_model(model);
    const auto scans = rig.run(5.0, 10);
    ASSERT_EQ(scans.size(), 10u) << rig.driver->state();
    EXPECT_EQ(scans[0].scan.size(),
              static_cast<std::size_t>(parameters.last_step - parameters.first_step + 1));
    const double beam_s = 60.0 / parameters.rpm / parameters.steps_per_turn;
    for (const ArrivedScan& arrived : scans) {
      EXPECT_LT(worst_error_m(arrived, beam_s), kToleranceM);
    }
    EXPECT_NEAR((scans[9].scan.utime - rig.emulator.last_first_beam()).seconds(), 0.0, 0.0011);
  }
}

TEST(HokuyoDriver, ALaserLeftTellingItsTimeMeasures) {
  for (const char* model : {"URG-04LX", "UST-10LX"}) {
    HokuyoEmulatorOptions device;
    device.model = model;
    Rig rig(device);
    rig.emulator.receive(ascii("TM0\n"), 115'200, rig.line.now());
    EXPECT_EQ(rig.run(1.0, 2).size(), 2u) << rig.driver->state();
  }
}

TEST(HokuyoDriver, FindsASerialLaserAndRaisesItsSpeed) {
  HokuyoEmulatorOptions device;
  device.baud = 19'200;
  HokuyoOptions options;
  options.baud = 115'200;
  Rig rig(device, options);
  const auto scans = rig.run(6.0, 3);
  ASSERT_EQ(scans.size(), 3u) << rig.driver->state();
  EXPECT_NEAR((scans[2].scan.utime - rig.emulator.last_first_beam()).seconds(), 0.0, 0.0011);
  rig.connect();  // found at 115200 now
  EXPECT_EQ(rig.run(3.0, 1).size(), 1u);
}

TEST(HokuyoDriver, MergesStepsAndSkipsTurns) {
  HokuyoOptions options;
  options.cluster = 3;
  options.skip = 1;
  Rig rig({}, options);
  const auto scans = rig.run(5.0, 4);
  ASSERT_EQ(scans.size(), 4u);
  EXPECT_EQ(scans[0].scan.size(), 228u);
  EXPECT_NEAR((scans[3].scan.utime - scans[2].scan.utime).seconds(), 0.2, 0.002);
}

// The nearest of the merged steps counts. Its beam points to the middle of them, so that walls that
// fall off to the left and to the right are wrong alike.
TEST(HokuyoDriver, AMergedBeamPointsToTheMiddleOfItsSteps) {
  for (const double slope : {1.0, -1.0}) {
    HokuyoEmulator emulator(
        [slope](const LaserSweep& sweep) {
          std::vector<double> ranges_m;
          for (int i = 0; i < sweep.beams; ++i) {
            ranges_m.push_back(3.0 + 0.5 * slope *
                                         (sweep.first_bearing_rad + i * sweep.bearing_step_rad));
          }
          return ranges_m;
        },
        {});
    SimulatedLine line(emulator);
    const auto stream = line.open({});
    HokuyoOptions options;
    options.cluster = 5;
    HokuyoDriver driver(*stream, options, [&line] { return line.now(); });
    const auto scans = step_until(driver, line, 5.0, have(1));
    ASSERT_EQ(scans.size(), 1u);
    const LaserScan& scan = scans[0].scan;
    const double two_steps_m = 0.5 * 2.0 * 2.0 * std::numbers::pi / 1024.0;
    for (std::size_t i = 0; i + 1 < scan.size(); ++i) {  // the last has fewer steps
      EXPECT_NEAR(static_cast<double>(scan.ranges_m[i]),
                  3.0 + 0.5 * slope * scan.bearing_rad(i) - two_steps_m, 0.0006);
    }
  }
}

TEST(HokuyoDriver, IsBackAfterResetPlugAndSilence) {
  Rig rig;
  ASSERT_EQ(rig.run(3.0, 3).size(), 3u);
  rig.emulator.power_cycle(rig.line.now());
  Utime since = rig.line.now();
  ASSERT_EQ(rig.run(6.0, 1).size(), 1u);
  EXPECT_LT((rig.line.now() - since).seconds(), 0.3 + 2.0 + 1.0);
  rig.line.at(rig.line.now() + Duration::from_us(20'000), [&] { rig.line.unplug(); });
  EXPECT_THROW(rig.run(2.0, 1000), StreamLost);
  rig.line.plug_in();
  rig.connect();
  since = rig.line.now();
  ASSERT_EQ(rig.run(6.0, 1).size(), 1u);
  EXPECT_LT((rig.line.now() - since).seconds(), 1.0);
  rig.line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  rig.run(3.0, 1);
  EXPECT_THAT(rig.driver->state(), HasSubstr("the scans stopped"));
  rig.line.set_tamper_to_client({});
  EXPECT_EQ(rig.run(3.0, 1).size(), 1u);
}

TEST(HokuyoDriver, LetsNoDamagedScanThrough) {
  Rig rig;
  ASSERT_EQ(rig.run(3.0, 1).size(), 1u);
  std::mt19937 random(8);
  rig.line.set_tamper_to_client([&](Bytes& bytes) {
    if (random() % 3 == 0)
      bytes[random() % bytes.size()] ^= static_cast<uint8_t>(1 << random() % 8);
  });
  const auto scans = rig.run(20.0, 1000);
  EXPECT_GT(scans.size(), 80u);
  EXPECT_GT(rig.driver->counts().drops.at("bad_checksum"), 20);
  for (const ArrivedScan& arrived : scans) {
    EXPECT_LT(worst_error_m(arrived, 0.1 / 1024), kToleranceM);
  }
}

TEST(HokuyoEmulator, AnswersAsTheVendorsToolsAsk) {
  HokuyoEmulator emulator(test_world, {});
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  const auto ask = [&](const std::string& line) {
    emulator.receive(ascii(line), 115'200, now);
    now = now + Duration::from_us(5000);
    Bytes out;
    emulator.advance(now, out);
    return std::string(out.begin(), out.end());
  };
  EXPECT_EQ(ask("\nQT\n"), "QT\n00P\n\n");
  EXPECT_EQ(ask("BM;tag\r\n"), "BM;tag\n00P\n\n");
  EXPECT_EQ(ask("BM\n"), "BM\n02R\n\n");
  EXPECT_EQ(ask("XX\n"), "XX\n0Ee\n\n");
  EXPECT_EQ(ask("SS115200\n"), "SS115200\n00P\n\n");
  EXPECT_EQ(ask("MD0044072601000\n"), "MD0044072601000\n04T\n\n");
  EXPECT_THAT(ask("VV\n"), HasSubstr("PROT:SCIP 2.0;"));
  EXPECT_THAT(ask("II\n"), HasSubstr("LASR:ON;"));
  EXPECT_EQ(ask("MD0044072501002\n"), "MD0044072501002\n00P\n\n");
  Bytes out;
  for (int i = 0; i < 50; ++i) emulator.advance(now = now + Duration::from_us(10'000), out);
  EXPECT_EQ(replies_in({out}).size(), 2u);
  EXPECT_EQ(replies_in({out})[1].echo, "MD0044072501000");
}

struct Asked {
  explicit Asked(HokuyoEmulatorOptions options = {}) : emulator(test_world, options) {
    emulator.on_connection(true, now);
  }
  std::string ask(const std::string& line, int wait_us = 5000, int baud = 115'200) {
    emulator.receive(ascii(line), baud, now);
    Bytes out;
    for (int at = 0; at < wait_us; at += 1000) {
      emulator.advance(now = now + Duration::from_us(1000), out);
    }
    return std::string(out.begin(), out.end());
  }
  HokuyoEmulator emulator;
  Utime now = Utime::from_us(1'000'000'000);
};

TEST(HokuyoEmulator, TellsItsTimeBetweenTm0AndTm2) {
  Asked laser;
  EXPECT_EQ(laser.ask("TM2\n"), "TM2\n03S\n\n");
  EXPECT_EQ(laser.ask("TM1\n"), "TM1\n04T\n\n");
  EXPECT_EQ(laser.ask("TM0\n"), "TM0\n00P\n\n");
  EXPECT_EQ(laser.ask("QT\n"), "QT\n0Ee\n\n");  // how vendors' tools find this state
  ReplyParser parser;
  parser.push(ascii(laser.ask("TM1\n")));
  const auto reply = parser.next();
  ASSERT_TRUE(reply && reply->done() && reply->lines.size() == 1);
  EXPECT_EQ(decode_number(reply->lines[0]), 20u);  // four requests of 5 ms
  EXPECT_EQ(laser.ask("TM2\n"), "TM2\n00P\n\n");
  EXPECT_EQ(laser.ask("QT\n"), "QT\n00P\n\n");
}

// Seen at a real URG-04LX; the others from what was published of them.
TEST(HokuyoEmulator, AnswersAsItsModelDoes) {
  Asked urg;
  EXPECT_EQ(urg.ask("HS0\n").substr(0, 6), "HS0\n0C");
  EXPECT_EQ(urg.ask("CR00\n").substr(0, 7), "CR00\n00");
  urg.ask("BM\n");
  EXPECT_EQ(urg.ask("CR00\n").substr(0, 7), "CR00\n03");
  EXPECT_THAT(urg.ask("VV\n"), HasSubstr("PROD:SOKUIKI Sensor URG-04LX;"));
  urg.ask("", 300'000);
  EXPECT_THAT(urg.ask("II\n"), HasSubstr("TIME:000145;"));  // 325 ms
  HokuyoEmulatorOptions old;
  old.scip1 = true;
  Asked scip1(old);
  EXPECT_THAT(scip1.ask("V\n"), HasSubstr("PROT:00003,(SCIP 1.0)\n"));
  HokuyoEmulatorOptions ethernet;
  ethernet.model = "UST-10LX";
  Asked ust(ethernet);
  EXPECT_EQ(ust.ask("SS115200\n"), "SS115200\n0Ee\n\n");
  EXPECT_EQ(ust.ask("SCIP2.0\n"), "SCIP2.0\n0Ee\n\n");
  EXPECT_THAT(ust.ask("VV\n"), HasSubstr("PROD:UST-10LX;"));
}

TEST(HokuyoEmulator, IntensitiesAndEchoesAreTheLargeModels) {
  Asked urg;
  urg.ask("BM\n");
  EXPECT_EQ(urg.ask("GE0044072500\n"), "GE0044072500\n0Ee\n\n");
  EXPECT_EQ(urg.ask("HD0044072500\n"), "HD0044072500\n0Ee\n\n");
  HokuyoEmulatorOptions large;
  large.model = "UTM-30LX";
  Asked utm(large);
  utm.ask("BM\n");
  for (const char* line :
       {"GE0000108000", "HE0000108000", "HD0000108000", "ME0000108000001", "ND0000108002001"}) {
    const ScanRequest request = parse_scan_request(line).value();
    EXPECT_EQ(request.line().substr(0, 10), std::string(line).substr(0, 10));
    const auto replies = replies_in({ascii(utm.ask(std::string(line) + "\n", 100'000))});
    ASSERT_FALSE(replies.empty()) << line;
    const auto scan = decode_measurement(replies.back(), request);
    ASSERT_TRUE(scan.has_value()) << line;
    EXPECT_EQ(scan->values_mm.size(), static_cast<std::size_t>(request.values()));
    EXPECT_EQ(scan->intensities.size(), request.intensities ? scan->values_mm.size() : 0u);
    utm.ask("BM\n");  // a stream that has run out leaves it on, a single scan too
  }
}

TEST(HokuyoEmulator, RebootsWhenAskedTwice) {
  Asked laser;
  EXPECT_EQ(laser.ask("RB\n"), "RB\n01Q\n\n");
  EXPECT_EQ(laser.ask("QT\n"), "QT\n00P\n\n");
  EXPECT_EQ(laser.ask("RB\n"), "RB\n01Q\n\n");
  EXPECT_EQ(laser.ask("RB\n"), "RB\n00P\n\n");
  EXPECT_EQ(laser.ask("QT\n"), "");
  laser.ask("", 400'000);
  EXPECT_EQ(laser.ask("QT\n"), "QT\n00P\n\n");
}

TEST(HokuyoEmulator, OldFirmwareSpeaksScip1UntilToldOtherwise) {
  HokuyoEmulatorOptions old;
  old.scip1 = true;
  old.baud = 19'200;
  Asked laser(old);
  const auto ask = [&](const char* line, int wait_us = 200'000) {
    return laser.ask(line, wait_us, 19'200);
  };
  EXPECT_EQ(ask("QT\n"), "QT\nE\n\n");
  EXPECT_THAT(ask("V\n"), HasSubstr("V\n0\nVEND:Hokuyo Automatic Co.,Ltd.\n"));
  EXPECT_EQ(ask("L1\n"), "L1\n0\n\n");
  EXPECT_EQ(ask("G00076901\n"), "G00076901\nE\n\n");
  const std::string scan = ask("G00076801\n", 3'000'000);
  // 769 values of two characters in blocks of 64: 24 whole ones and a rest of two.
  EXPECT_EQ(scan.size(), 10 + 2 + 24 * 65 + 3 + 1u);
  EXPECT_EQ(scan.substr(0, 12), "G00076801\n0\n");
  const std::size_t ahead = 12 + 384 * 2 + 384 * 2 / 64;
  EXPECT_NEAR(decode_number(scan.substr(ahead, 2)).value(), 3000, 550);  // half a metre to and fro
  EXPECT_EQ(ask("SCIP2.0\n"), "SCIP2.0\n0\n\n");
  EXPECT_EQ(ask("QT\n"), "QT\n00P\n\n");
}

TEST(HokuyoDriver, MeasuresWithALaserOfOldFirmware) {
  HokuyoEmulatorOptions old;
  old.scip1 = true;
  Rig rig(old);
  EXPECT_EQ(rig.run(5.0, 2).size(), 2u) << rig.driver->state();
}

}  // namespace
}  // namespace marco::drivers::hokuyo
