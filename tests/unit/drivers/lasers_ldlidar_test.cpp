#include <gmock/gmock.h>

#include <algorithm>
#include <string_view>

#include "common/pose2.hpp"
#include "drivers/ldlidar/driver.hpp"
#include "simulator/devices/ldlidar/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::ldlidar {
namespace {

using ::testing::HasSubstr;

template <std::size_t kSize>
Bytes bytes_of(const std::array<uint8_t, kSize>& array) {
  return {array.begin(), array.end()};
}

// From the maker's manual of the LD06; its table misprints the last byte of the speed's packet.
const char* const kManual =
    "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 E2 "
    "C7 00 E9 C5 00 E5 C2 00 E5 C0 00 E5 BE 82 3A 1A 50";

TEST(LdlidarCodec, ManualsPacket) {
  PacketParser parser;
  parser.push(hex(kManual));
  const auto received = parser.next();
  ASSERT_TRUE(received.has_value());
  const Packet& packet = received->packet;
  EXPECT_EQ(packet.speed_deg_per_s, 2152);
  EXPECT_EQ(packet.start_cdeg, 32427);
  EXPECT_EQ(packet.end_cdeg, 33470);
  EXPECT_EQ(packet.stamp_ms, 6714);
  EXPECT_EQ(packet.samples.front(), (Sample{224, 228}));
  EXPECT_EQ(packet.samples.back(), (Sample{192, 229}));
  EXPECT_NEAR(sample_angle_deg(packet, 1), 324.27 + 10.43 / 11.0, 1e-9);
  EXPECT_EQ(bytes_of(encode_packet(packet)), hex(kManual));
  const std::string_view digits = "123456789";  // the check value of a CRC
  EXPECT_EQ(crc8({reinterpret_cast<const uint8_t*>(digits.data()), digits.size()}), 0xC3);
}

TEST(LdlidarCodec, AnglesRunThroughZero) {
  Packet packet;
  packet.start_cdeg = 35'900;
  packet.end_cdeg = 120;
  EXPECT_NEAR(sample_angle_deg(packet, 0), 359.0, 1e-9);
  EXPECT_NEAR(sample_angle_deg(packet, 5), 0.0, 1e-9);
  EXPECT_NEAR(sample_angle_deg(packet, 11), 1.2, 1e-9);
  packet.end_cdeg = 36'001;  // no angle: the CRC is right, the packet is not
  EXPECT_FALSE(decode_packet(encode_packet(packet)).has_value());
}

TEST(LdlidarParser, PacketsResynchronizeInAnySplit) {
  std::vector<Bytes> telegrams;
  std::mt19937 random(21);
  for (int i = 0; i < 8; ++i) {
    Packet packet;
    packet.start_cdeg = static_cast<int>(random() % 36'000);
    packet.stamp_ms = static_cast<int>(random() % kStampWrapMs);
    for (Sample& sample : packet.samples) {
      sample = {static_cast<int>(random() % 65'536), static_cast<int>(random() % 256)};
    }
    telegrams.push_back(bytes_of(encode_packet(packet)));
  }
  const auto parse = [](const std::vector<Bytes>& chunks) {
    PacketParser parser;
    std::vector<Bytes> found;
    for (const Bytes& chunk : chunks) {
      parser.push(chunk);
      while (const auto received = parser.next()) {
        found.push_back(bytes_of(encode_packet(received->packet)));
      }
    }
    return found;
  };
  EXPECT_EQ(parse(split_at_random(join(telegrams), random)), telegrams);
  // The CRC finds each error of one bit, and of up to eight bits in a row.
  expect_resynchronizes(telegrams, telegrams, parse, 400);
}

struct Rig {
  explicit Rig(const LdlidarOptions& options = {}, const LdlidarEmulatorOptions& device = {})
      : emulator(test_world, device),
        line(emulator),
        stream(line.open({9600})),
        driver(*stream, options, [this] { return line.now(); }) {}
  std::vector<ArrivedScan> run(double limit_s, std::size_t count) {
    return step_until(driver, line, limit_s, have(count));
  }
  LdlidarEmulator emulator;
  SimulatedLine line;
  std::unique_ptr<ByteStream> stream;
  LdlidarDriver driver;
};

// Angles are rounded to 0.01 deg (3 m/rad of the test world: 0.3 mm), ranges to 1 mm, and the world
// moves by 3.5 m/s, so that 0.3 ms of timing make 1 mm.
constexpr double kToleranceM = 0.0003 + 0.0005 + 0.001;

TEST(LdlidarDriver, KnowsTheModelByWhatArrives) {
  for (const auto& [device, baud, range_max_m] :
       {std::tuple{LdlidarEmulatorOptions{}, 230'400, 12.0}, std::tuple{stl27l(), 921'600, 25.0},
        std::tuple{LdlidarEmulatorOptions{115'200, 2300.0, 6.0}, 115'200, 12.0}}) {
    Rig rig({}, device);
    const auto scans = rig.run(8.0, 30);  // of 3 s at least: the stamps wrap after 1.5 s
    ASSERT_EQ(scans.size(), 30u) << rig.driver.state();
    for (const ArrivedScan& arrived : scans) {
      EXPECT_NEAR(static_cast<double>(arrived.scan.size()),
                  device.samples_per_s / device.turns_per_s, 1.0);
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << baud;
      ASSERT_EQ(arrived.intensities.size(), arrived.scan.size());
      EXPECT_EQ(arrived.intensities.front(), 200.0F);
    }
    EXPECT_THAT(rig.driver.state(), HasSubstr(std::to_string(baud) + " baud"));
    EXPECT_EQ(rig.driver.properties().range_max_m, range_max_m);
    EXPECT_EQ(rig.driver.counts().dropped(), 0);
  }
}

TEST(LdlidarDriver, LearnsAnyPeriod) {
  LdlidarEmulatorOptions device;
  device.samples_per_s = 4871.0;
  Rig rig({}, device);
  const auto scans = rig.run(20.0, 100);
  ASSERT_EQ(scans.size(), 100u);
  EXPECT_LT(worst_range_error_m(scans.front().scan), kToleranceM);
  EXPECT_LT(worst_range_error_m(scans.back().scan), kToleranceM);
}

TEST(LdlidarDriver, MirroredWhereTold) {
  LdlidarOptions options;
  options.clockwise = false;
  Rig plain, mirrored(options);
  const LaserScan one = plain.run(3.0, 1).at(0).scan, other = mirrored.run(3.0, 1).at(0).scan;
  ASSERT_EQ(one.size(), other.size());
  EXPECT_LT(one.bearing_rad(1), one.bearing_rad(0));
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(normalize_angle(one.bearing_rad(i) + other.bearing_rad(i)), 0.0, 1e-6);
  }
}

TEST(LdlidarDriver, NothingIsZero) {
  LdlidarEmulatorOptions device;
  device.range_max_m = 3.0;
  Rig rig({}, device);
  const auto scans = rig.run(3.0, 2);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_GT(std::count(scans[1].scan.ranges_m.begin(), scans[1].scan.ranges_m.end(), 0.0f), 100);
}

// A turn without the samples of a lost packet is a turn still: all others keep their times.
TEST(LdlidarDriver, LostPacketsLeaveTheOthersTheirTimes) {
  for (const LdlidarEmulatorOptions& device : {LdlidarEmulatorOptions{}, stl27l()}) {
    Rig rig({}, device);
    ASSERT_EQ(rig.run(5.0, 1).size(), 1u);
    std::mt19937 random(8);
    rig.line.set_tamper_to_client([&](Bytes& bytes) {
      const auto kind = random() % 300;
      if (kind < 2) bytes[random() % bytes.size()] ^= static_cast<uint8_t>(1 << random() % 8);
      if (kind == 3) bytes.erase(bytes.begin());
      if (kind == 4) bytes.insert(bytes.begin(), bytes[0]);
      if (kind == 5) bytes.clear();
    });
    const auto scans = rig.run(20.0, 1000);
    EXPECT_GT(scans.size(), 180u);
    EXPECT_GT(rig.driver.counts().drops.at("lost_samples"), 20);
    std::size_t short_ones = 0;
    for (const ArrivedScan& arrived : scans) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM);
      if (static_cast<double>(arrived.scan.size()) < 0.99 * device.samples_per_s / 10.0) {
        ++short_ones;
      }
    }
    EXPECT_GT(short_ones, 10u);
  }
}

// More than a turn is lost: by its angles alone it would be a gap of a few samples.
TEST(LdlidarDriver, AGapOfATurnIsKnownByTheStamps) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 10).size(), 10u);
  for (int i = 0; i < 10; ++i) {
    rig.line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
    rig.line.wait(Duration::from_seconds(0.1 + 0.001 * i));
    rig.line.set_tamper_to_client({});
    for (const ArrivedScan& arrived : rig.run(2.0, 3)) {
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM) << i;
    }
  }
  EXPECT_GE(rig.driver.counts().drops.at("lost_turn"), 10);
}

TEST(LdlidarDriver, SaysWhatIsWrong) {
  Rig rig;
  ASSERT_EQ(rig.run(5.0, 3).size(), 3u);
  EXPECT_TRUE(rig.driver.answers());
  rig.line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  rig.run(0.7, 1);
  EXPECT_THAT(rig.driver.state(), HasSubstr("looking for the laser"));
  EXPECT_THAT(rig.driver.state(), HasSubstr("the packets stopped"));
  EXPECT_FALSE(rig.driver.answers());
}

}  // namespace
}  // namespace marco::drivers::ldlidar
