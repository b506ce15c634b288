#include <gmock/gmock.h>

#include "drivers/rplidar/driver.hpp"
#include "drivers/rplidar/ultra_capsule.hpp"
#include "drivers/rplidar/ultra_dense_capsule.hpp"
#include "simulator/devices/rplidar/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::rplidar {
namespace {

using ::testing::HasSubstr;

template <std::size_t kSize>
Bytes bytes_of(const std::array<uint8_t, kSize>& array) {
  return {array.begin(), array.end()};
}

TEST(RplidarCodec, RequestVectors) {
  const std::vector<std::pair<Bytes, const char*>> vectors{
      {encode_request(kStop), "A5 25"},
      {encode_request(kReset), "A5 40"},
      {encode_request(kScan), "A5 20"},
      {encode_request(kForceScan), "A5 21"},
      {encode_request(kGetInfo), "A5 50"},
      {encode_request(kGetHealth), "A5 52"},
      {encode_request(kGetSampleRate), "A5 59"},
      {encode_request(kExpressScan, Bytes(5, 0)), "A5 82 05 00 00 00 00 00 22"},
      {motor_request(660), "A5 F0 02 94 02 C1"},
      {motor_request(0), "A5 F0 02 00 00 57"},
      {encode_request(kGetAccessoryFlag, Bytes(4, 0)), "A5 FF 04 00 00 00 00 5E"},
  };
  RequestParser parser;
  for (const auto& [built, line] : vectors) {
    EXPECT_EQ(built, hex(line));
    parser.push(hex(line));
    const auto request = parser.next();
    ASSERT_TRUE(request.has_value()) << line;
    EXPECT_EQ(encode_request(request->command, request->data), built);
  }
  Bytes damaged = motor_request(660);
  damaged[3] ^= 4;
  parser.push(join({hex("00 A5"), damaged, encode_request(kStop)}));
  EXPECT_EQ(parser.next()->command, kStop);
}

TEST(RplidarCodec, DescriptorsAndAnswers) {
  EXPECT_EQ(encode_descriptor(5, true, kNodes), hex("A5 5A 05 00 00 40 81"));
  EXPECT_EQ(encode_descriptor(20, false, kInfo), hex("A5 5A 14 00 00 00 04"));
  EXPECT_EQ(encode_descriptor(3, false, kHealth), hex("A5 5A 03 00 00 00 06"));
  EXPECT_EQ(encode_descriptor(4, false, kSampleRate), hex("A5 5A 04 00 00 00 15"));
  EXPECT_EQ(encode_descriptor(84, true, kCapsules), hex("A5 5A 54 00 00 40 82"));
  EXPECT_EQ(encode_descriptor(4, false, kAccessoryFlag), hex("A5 5A 04 00 00 00 FF"));
  AnswerParser parser;
  parser.push(hex("00 A5 A5 5A 04 00 00 00 15 FC 01 FE 00"));
  const auto block = parser.next();
  ASSERT_TRUE(block.has_value());
  EXPECT_EQ(block->kind, kSampleRate);
  EXPECT_EQ(block->data, hex("FC 01 FE 00"));
  EXPECT_EQ(parser.garbage_bytes(), 2);
}

TEST(RplidarCodec, NodeVectors) {
  const std::vector<std::pair<Node, const char*>> vectors{
      {{true, 47, 0, 4000}, "BD 01 00 A0 0F"},
      {{false, 47, 90 * 64, 10001}, "BE 01 2D 11 27"},
      {{false, 0, 180 * 64 + 32, 0}, "02 41 5A 00 00"}};
  for (const auto& [node, line] : vectors) {
    EXPECT_EQ(bytes_of(encode_node(node)), hex(line));
    EXPECT_EQ(decode_node(encode_node(node)), node);
  }
  EXPECT_FALSE(decode_node(std::array<uint8_t, 5>{0x03, 1, 0, 0, 0}).has_value());
  EXPECT_FALSE(decode_node(std::array<uint8_t, 5>{0x01, 0, 0, 0, 0}).has_value());
}

Capsule ramp(int start_q6, bool first) {
  Capsule capsule;
  capsule.first = first;
  capsule.start_q6 = start_q6;
  for (int i = 0; i < kCapsuleSamples; ++i) {
    capsule.distance_mm[static_cast<std::size_t>(i)] = 1000 + i;
  }
  return capsule;
}

TEST(RplidarCodec, CapsuleVector) {
  const Bytes bytes = bytes_of(encode_capsule(ramp(0, true)));
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 14),
            hex("A0 58 00 80 A0 0F A4 0F 00 A8 0F AC 0F 00"));
  EXPECT_EQ(decode_capsule(encode_capsule(ramp(0, true))), ramp(0, true));
  Capsule odd = ramp(359 * 64, false);
  for (int i = 0; i < kCapsuleSamples; ++i) odd.offset_q3[static_cast<std::size_t>(i)] = 63 - i;
  EXPECT_EQ(decode_capsule(encode_capsule(odd)), odd);
  const Capsule next = ramp(15 * 64, false);
  const auto samples = samples_of(odd, next);
  ASSERT_EQ(samples.size(), 32u);
  EXPECT_DOUBLE_EQ(samples[0].angle_deg, 359.0 - 63 / 8.0);
  EXPECT_NEAR(samples[16].angle_deg, 359.0 + 8.0 - 47 / 8.0 - 360.0, 1e-12);
  EXPECT_EQ(samples[16].range_mm, 1016);
}

// The xor of eight bits is weak: of 256 damages that leave the marks alone one escapes it, and each
// doubled 0 in front of a last 0. So a capsule counts, as in the driver, which needs the next one's
// angle anyway, only when another follows it without a gap.
TEST(RplidarParser, CapsulesResynchronizeInAnySplit) {
  std::vector<Bytes> telegrams;
  std::vector<Bytes> messages;
  std::mt19937 random(12);
  for (int i = 0; i < 8; ++i) {
    Capsule capsule;
    capsule.start_q6 = static_cast<int>(random() % (360 * 64));
    for (int& distance : capsule.distance_mm) distance = static_cast<int>(random() % 16384);
    telegrams.push_back(bytes_of(encode_capsule(capsule)));
    messages.push_back(telegrams.back());
  }
  const auto parse = [](const std::vector<Bytes>& chunks) {
    AnswerParser parser;
    parser.push(encode_descriptor(kCapsuleSize, true, kCapsules));
    std::vector<Bytes> found;
    Bytes waiting;
    for (const Bytes& chunk : chunks) {
      parser.push(chunk);
      while (const auto block = parser.next()) {
        if (block->continuous && !waiting.empty()) found.push_back(waiting);
        waiting = bytes_of(encode_capsule(block->capsule));
      }
    }
    return found;
  };
  messages.pop_back();
  EXPECT_EQ(parse(split_at_random(join(telegrams), random)), messages);
  expect_resynchronizes(telegrams, messages, parse, 400, 1);
}

// Nodes have no checksum: a distance flipped on the line cannot be told. What must hold is that the
// place is found again, after bytes lost or put in, before the second node behind the damage.
TEST(RplidarParser, NodesFindTheirPlaceAgain) {
  std::mt19937 random(13);
  for (int round = 0; round < 300; ++round) {
    std::vector<Node> nodes;
    std::vector<Bytes> telegrams;
    for (int i = 0; i < 40; ++i) {
      nodes.push_back({i == 0, 47, i * 70, static_cast<int>(4000 + random() % 4000)});
      telegrams.push_back(bytes_of(encode_node(nodes.back())));
    }
    const std::size_t hurt = 5 + random() % 25;
    Bytes& victim = telegrams[hurt];
    if (round % 2 == 0) {
      victim.erase(victim.begin() + static_cast<std::ptrdiff_t>(random() % victim.size()));
    } else {
      victim.insert(victim.begin() + static_cast<std::ptrdiff_t>(random() % victim.size()),
                    static_cast<uint8_t>(random()));
    }
    AnswerParser parser;
    parser.push(encode_descriptor(kNodeSize, true, kNodes));
    std::vector<Node> found;
    for (const Bytes& chunk : split_at_random(join(telegrams), random)) {
      parser.push(chunk);
      while (const auto block = parser.next()) found.push_back(block->node);
    }
    // The node before the damage is not confirmed by its next; the damaged one and the next may be
    // lost; the very last waits for its next.
    const auto whole_before = static_cast<std::ptrdiff_t>(hurt) - 1;
    const auto first_after = static_cast<std::ptrdiff_t>(hurt) + 2;
    const std::vector<Node> before(nodes.begin(), nodes.begin() + whole_before);
    const std::vector<Node> after(nodes.begin() + first_after, nodes.end() - 1);
    ASSERT_GE(found.size(), before.size() + after.size()) << "round " << round;
    EXPECT_LE(found.size(), nodes.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), found.begin())) << "round " << round;
    EXPECT_TRUE(std::equal(after.rbegin(), after.rend(), found.rbegin())) << "round " << round;
  }
}

struct Rig {
  explicit Rig(RplidarOptions options = {}, RplidarEmulatorOptions device = {})
      : emulator(test_world, device), line(emulator), options_(options) {
    connect();
  }
  void connect() {
    driver.reset();
    stream.reset();
    stream = line.open({9600});
    driver = std::make_unique<RplidarDriver>(*stream, options_, [this] { return line.now(); });
  }
  std::vector<ArrivedScan> run(double limit_s, std::size_t count) {
    return step_until(*driver, line, limit_s, have(count));
  }
  RplidarEmulator emulator;
  SimulatedLine line;
  RplidarOptions options_;
  std::unique_ptr<ByteStream> stream;
  std::unique_ptr<RplidarDriver> driver;
};

// Angles are cut to 1/64 deg (3 m/rad of the test world: 0.8 mm), ranges to 1 mm, and the world
// moves by 3.5 m/s, so that 0.3 ms of timing make 1 mm.
constexpr double kToleranceM = 0.0008 + 0.0005 + 0.001;

TEST(RplidarDriver, GathersTurnsInBothModes) {
  for (const char* mode : {"standard", "express"}) {
    RplidarOptions options;
    options.mode = mode;
    Rig rig(options);
    const auto scans = rig.run(6.0, 10);
    ASSERT_EQ(scans.size(), 10u) << rig.driver->state();
    const double samples = 1.0 / 5.5 / (std::string(mode) == "standard" ? 508e-6 : 254e-6);
    for (const ArrivedScan& arrived : scans) {
      EXPECT_NEAR(static_cast<double>(arrived.scan.size()), samples, 1.0);
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << mode;
      EXPECT_EQ(arrived.scan.bearings_rad.size(), arrived.scan.size());
      EXPECT_EQ(arrived.scan.time_offsets_s.size(), arrived.scan.size());
    }
  }
}

// Slamtec's capsule of 40 distances, 1000 to 1039 mm, the first of a scan: frames as their SDK
// reads them.
TEST(RplidarCodec, DenseCapsuleVector) {
  Capsule capsule = ramp(0, true);
  capsule.samples = kDenseSamples;
  for (int i = 0; i < kDenseSamples; ++i)
    capsule.distance_mm[static_cast<std::size_t>(i)] = 1000 + i;
  const Bytes bytes = bytes_of(encode_dense_capsule(capsule));
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 8), hex("A0 58 00 80 E8 03 E9 03"));
  EXPECT_EQ(Bytes(bytes.end() - 2, bytes.end()), hex("0F 04"));
  EXPECT_EQ(decode_dense_capsule(encode_dense_capsule(capsule)), capsule);
  Capsule next;
  next.samples = kDenseSamples;
  next.start_q6 = 288;  // 4.5 deg
  next.distance_mm.fill(2000);
  const Bytes second = bytes_of(encode_dense_capsule(next));
  EXPECT_EQ(Bytes(second.begin(), second.begin() + 6), hex("A1 52 20 01 D0 07"));
  ASSERT_EQ(samples_of(capsule, next).size(), 40u);
  EXPECT_DOUBLE_EQ(samples_of(capsule, next)[39].angle_deg, 4.3875);
  EXPECT_EQ(motor_speed_request(600), hex("A5 A8 02 58 02 55"));
  EXPECT_EQ(motor_speed_request(0), hex("A5 A8 02 00 00 0F"));
  EXPECT_EQ(configuration_request(kModeSamplePeriod, 0), hex("A5 84 06 71 00 00 00 00 00 56"));
}

TEST(RplidarDriver, FindsC1AndSAtTheirSpeedsAndReadsTheirDenseCapsules) {
  for (const RplidarEmulatorOptions& device : {c1(), s2(), s3()}) {
    Rig rig({}, device);
    const auto scans = rig.run(12.0, 10);
    ASSERT_EQ(scans.size(), 10u) << rig.driver->state();
    EXPECT_NEAR(static_cast<double>(scans.back().scan.size()), 0.1 / device.express_s, 1.0);
    for (const ArrivedScan& arrived : scans) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << rig.driver->state();
    }
    EXPECT_NEAR(rig.driver->properties().range_max_m, device.range_max_m, 0.01);
    EXPECT_THAT(rig.driver->state(), HasSubstr(model_name(device.model)));
    EXPECT_THAT(rig.driver->state(), HasSubstr(std::to_string(device.baud) + " baud"));
  }
}

// Of each band its first and its last range, and what lies between two steps. The bytes of the
// first two cabins by hand: 1 step of 2 mm, strength 63; 682 steps of 3 mm behind 2046,
// strength 31.
TEST(RplidarCodec, UltraDenseCapsuleVector) {
  Capsule capsule;
  capsule.samples = kUltraDenseSamples;
  capsule.first = true;
  capsule.start_q6 = 288;
  const std::vector<int> ranges_mm{2, 4092, 0, 2045, 2046, 8186, 8187, 24566, 24567, 65522, 70000};
  std::copy(ranges_mm.begin(), ranges_mm.end(), capsule.distance_mm.begin());
  const auto encoded = encode_ultra_dense_capsule(capsule);
  const Bytes bytes = bytes_of(encoded);
  EXPECT_EQ(Bytes(bytes.begin() + 2, bytes.begin() + 15),
            hex("00 00 00 00 00 00 20 81 04 F0 A9 EA 33"));
  const auto decoded = decode_ultra_dense_capsule(encoded);
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(decoded->first);
  EXPECT_EQ(decoded->start_q6, 288);
  EXPECT_EQ(decoded->samples, 64);
  EXPECT_EQ(std::vector<int>(decoded->distance_mm.begin(), decoded->distance_mm.begin() + 11),
            (std::vector<int>{2, 4092, 0, 2046, 2046, 8187, 8187, 24567, 24567, 65522, 65522}));
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    auto damaged = encoded;
    damaged[at] ^= 0x10;
    EXPECT_FALSE(decode_ultra_dense_capsule(damaged)) << at;
  }
}

// Frames as Slamtec's SDK reads them: cabins of 1000, 1500 and no range, then 29 of 3000 mm.
TEST(RplidarCodec, UltraCapsuleVector) {
  Bytes first = hex("AD 5D 80 82 F4 12 C0 FF EE F3 1F 80 00 D0 BF 00");
  for (int i = 0; i < 29; ++i) first = join({first, hex("EE 05 00 00")});
  Bytes second = hex("A5 50 00 05");
  for (int i = 0; i < 32; ++i) second = join({second, hex("EE 05 00 00")});
  AnswerParser parser;
  parser.push(join({hex("A5 5A 84 00 00 40 84"), first, second}));
  const auto block = parser.next(), next = parser.next();
  ASSERT_TRUE(block && next);
  EXPECT_EQ(block->kind, kUltraCapsules);
  EXPECT_TRUE(block->capsule.first);
  EXPECT_EQ(bytes_of(encode_ultra_capsule(block->capsule)), first);
  EXPECT_EQ(bytes_of(encode_ultra_capsule(next->capsule)), second);
  const auto samples = samples_of(block->capsule, next->capsule);
  ASSERT_EQ(samples.size(), 96u);
  std::vector<int> ranges_mm;
  for (std::size_t i = 0; i < 9; ++i) ranges_mm.push_back(samples[i].range_mm);
  EXPECT_EQ(ranges_mm, (std::vector<int>{1000, 1002, 1498, 1500, 0, 0, 0, 2988, 3008}));
  EXPECT_NEAR(samples[0].angle_deg, 3.343, 0.002);
  EXPECT_NEAR(samples[8].angle_deg, 3.280, 0.002);
  EXPECT_NEAR(ultra_offset_deg(1000), 6.66, 0.005);
  EXPECT_NEAR(ultra_offset_deg(5000), 7.78, 0.005);
  EXPECT_EQ(ultra_offset_deg(0), 7.5);
}

TEST(RplidarCodec, UltraRangesReadAsTheyWereWritten) {
  std::mt19937 random(4);
  for (int round = 0; round < 200; ++round) {
    std::array<int, kUltraSamples> ranges_mm{};
    const int around_mm = 60 + static_cast<int>(random() % 24'000);
    for (int& range_mm : ranges_mm) {
      range_mm = random() % 9 == 0 ? 0 : around_mm + static_cast<int>(random() % 100);
    }
    Capsule capsule, next;
    set_ultra_ranges(capsule, ranges_mm, ranges_mm[0]);
    set_ultra_ranges(next, ranges_mm, 0);
    const auto read_mm = ultra_ranges_mm(capsule, next);
    for (std::size_t i = 0; i < read_mm.size(); ++i) {
      const bool told = ranges_mm[i] > 0 && read_mm[i] > 0;
      // Between two that saw nothing, and nothing itself, there is no difference to tell.
      if (i % 3 == 0) {
        EXPECT_EQ(told, ranges_mm[i] > 0);
      }
      if (told) {
        EXPECT_NEAR(read_mm[i], ranges_mm[i], around_mm < 16'000 ? 4 : 8);
      } else if (ranges_mm[i] == 0) {
        EXPECT_EQ(read_mm[i], 0);
      }
    }
  }
}

// The offsets are settled to 0.06 deg: 4 mm of the test world. Ranges come in steps of 8 mm.
TEST(RplidarDriver, FindsA3AndS1AndReadsTheirUltraCapsules) {
  for (const RplidarEmulatorOptions& device : {a3(), s1()}) {
    Rig rig({}, device);
    const auto scans = rig.run(12.0, 10);
    ASSERT_EQ(scans.size(), 10u) << rig.driver->state();
    EXPECT_NEAR(static_cast<double>(scans.back().scan.size()), 0.1 / device.express_s, 2.0);
    for (const ArrivedScan& arrived : scans) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM + 0.004 + 0.004);
    }
    EXPECT_NEAR(rig.driver->properties().range_max_m, device.range_max_m, 0.01);
    EXPECT_THAT(rig.driver->state(), HasSubstr(model_name(device.model)));
    EXPECT_THAT(rig.driver->state(), HasSubstr("256000 baud"));
    EXPECT_EQ(rig.driver->counts().dropped(), 0);
  }
}

TEST(RplidarDriver, ALaserWhoseUsualModeIsUnknownScansInStandard) {
  RplidarEmulatorOptions device = s2();
  device.typical_mode = 0;  // answers with nodes
  Rig rig({}, device);
  EXPECT_EQ(rig.run(8.0, 3).size(), 3u) << rig.driver->state();
  EXPECT_THAT(rig.driver->state(), HasSubstr("standard"));
}

TEST(RplidarDriver, FollowsALaserWhoseClockIsOff) {
  RplidarEmulatorOptions device;
  device.express_s = 254.9e-6;  // says 255, is 0.04 % faster
  Rig rig({}, device);
  const auto scans = rig.run(20.0, 80);
  ASSERT_EQ(scans.size(), 80u);
  EXPECT_LT(worst_range_error_m(scans.back().scan), kToleranceM);
}

TEST(RplidarDriver, NothingIsZeroAndErrorsAreReported) {
  RplidarEmulatorOptions device;
  device.range_max_m = 3.0;
  Rig rig({}, device);
  const auto scans = rig.run(6.0, 2);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_GT(std::count(scans[1].scan.ranges_m.begin(), scans[1].scan.ranges_m.end(), 0.0f), 100);
  device.health = 2;
  Rig ill({}, device);
  EXPECT_TRUE(ill.run(3.0, 1).empty());
  EXPECT_THAT(ill.driver->state(), HasSubstr("reports error"));
}

TEST(RplidarDriver, IsBackAfterResetPlugAndSilence) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 3).size(), 3u);
  rig.emulator.power_cycle(rig.line.now());
  Utime since = rig.line.now();
  ASSERT_EQ(rig.run(6.0, 1).size(), 1u);
  EXPECT_LT((rig.line.now() - since).seconds(), 0.5 + 2.0 + 0.4);
  rig.line.at(rig.line.now() + Duration::from_us(20'000), [&] { rig.line.unplug(); });
  EXPECT_THROW(rig.run(2.0, 1000), StreamLost);
  rig.line.plug_in();
  rig.connect();
  since = rig.line.now();
  ASSERT_EQ(rig.run(6.0, 1).size(), 1u);
  EXPECT_LT((rig.line.now() - since).seconds(), 1.0);
  rig.line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  rig.run(0.7, 1);
  EXPECT_THAT(rig.driver->state(), HasSubstr("the samples stopped"));
  rig.line.set_tamper_to_client({});
  EXPECT_EQ(rig.run(3.0, 1).size(), 1u);
}

TEST(RplidarDriver, LetsNoDamagedCapsuleThrough) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 1).size(), 1u);
  std::mt19937 random(8);
  rig.line.set_tamper_to_client([&](Bytes& bytes) {
    const auto kind = random() % 300;
    if (kind < 2) bytes[random() % bytes.size()] ^= static_cast<uint8_t>(1 << random() % 8);
    if (kind == 3) bytes.erase(bytes.begin());
    if (kind == 4) bytes.insert(bytes.begin(), bytes[0]);
    if (kind == 5) {
      const auto zero = std::find(bytes.begin(), bytes.end(), 0);
      if (zero != bytes.end()) bytes.insert(zero, 0);
    }
  });
  const auto scans = rig.run(30.0, 1000);
  EXPECT_GT(scans.size(), 15u);
  EXPECT_GT(rig.driver->counts().drops.at("lost_capsule"), 10);
  for (const ArrivedScan& arrived : scans) {
    EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM);
  }
}

TEST(RplidarDriver, NoticesACapsuleThatVanishedWhole) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 1).size(), 1u);
  // A receiver that was late by just one capsule.
  int to_lose = 0;
  rig.line.set_tamper_to_client([&](Bytes& bytes) {
    while (to_lose > 0 && !bytes.empty()) {
      bytes.erase(bytes.begin());
      --to_lose;
    }
  });
  for (int i = 0; i < 5; ++i) {
    ASSERT_GE(rig.run(2.0, 3).size(), 3u);
    to_lose = static_cast<int>(kCapsuleSize);
    for (const ArrivedScan& arrived : rig.run(1.0, 4)) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM);
    }
  }
  EXPECT_EQ(rig.driver->counts().drops.at("lost_capsule"), 5);
}

TEST(RplidarEmulator, AnA2TurnsWhenItsMotorIsToldTo) {
  RplidarEmulatorOptions a2;
  a2.model = 0x28;
  RplidarEmulator emulator(test_world, a2);
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  const auto nodes_after = [&](const Bytes& request) {
    emulator.receive(request, 115'200, now);
    AnswerParser parser;
    for (int i = 0; i < 200; ++i) {
      Bytes out;
      emulator.advance(now = now + Duration::from_us(1000), out);
      parser.push(out);
    }
    int good = 0;
    while (const auto block = parser.next()) good += block->node.distance_q2 > 0 ? 1 : 0;
    return good;
  };
  EXPECT_EQ(nodes_after(encode_request(kScan)), 0);
  emulator.receive(encode_request(kStop), 115'200, now);
  nodes_after(motor_request(660));
  EXPECT_GT(nodes_after(encode_request(kForceScan)), 300);  // 0.2 s of 508 us
  RplidarOptions options;
  Rig rig(options, a2);  // our own driver turns it
  EXPECT_EQ(rig.run(5.0, 2).size(), 2u) << rig.driver->state();
}

}  // namespace
}  // namespace marco::drivers::rplidar
