#include <gmock/gmock.h>

#include "drivers/leuze/driver.hpp"
#include "drivers/leuze/service_driver.hpp"
#include "simulator/devices/leuze/emulator.hpp"
#include "simulator/devices/leuze/service_emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::leuze {
namespace {

using ::testing::HasSubstr;

Telegram telegram_of(const std::vector<uint16_t>& values_mm) {
  Telegram telegram;
  telegram.scan_number = 1;
  telegram.values_mm = values_mm;
  return telegram;
}

std::vector<Telegram> telegrams_in(const std::vector<Bytes>& chunks) {
  TelegramParser parser;
  std::vector<Telegram> found;
  for (const Bytes& chunk : chunks) {
    parser.push(chunk);
    while (const auto telegram = parser.next()) found.push_back(*telegram);
  }
  return found;
}

TEST(LeuzeCodec, VectorsBothWays) {
  const std::vector<std::pair<Telegram, const char*>> vectors{
      {telegram_of({1000, 2000, 3000}),
       "00 00 23 09 00 FE 00 FE 00 FE 01 FE 04 00 01 00 09 03 E8 07 D0 0B B8 A8 00 00 00"},
      {telegram_of({0, 0}),
       "00 00 23 09 00 FE 00 FE 00 FE 01 FE 04 00 01 00 05 00 00 FF 00 00 FF 2B 00 00 00"}};
  for (const auto& [telegram, line] : vectors) {
    EXPECT_EQ(encode_telegram(telegram), hex(line));
    EXPECT_THAT(telegrams_in({hex(line)}), ::testing::ElementsAre(telegram));
  }
  const Bytes full = encode_telegram(telegram_of(std::vector<uint16_t>(133, 2000)));
  EXPECT_EQ(full.size(), 287u);
  EXPECT_EQ(full[full.size() - 4], 0xEA);
  EXPECT_EQ(Bytes(full.begin() + 12, full.begin() + 19), hex("04 00 01 02 11 07 D0"));
}

// Two indices of a beam and the step give the number of beams once, the length of the telegram
// gives it again, and the last index must be a beam's.
TEST(LeuzeCodec, RefusesIndicesThatFitNoBeams) {
  const auto body_of = [](int step, int first, int last, std::size_t beams) {
    Bytes body = hex("23 09 00 FE 00 FE 00 FE 01 FE");
    body.push_back(static_cast<uint8_t>(step));
    for (const int index : {first, last}) {
      body.push_back(static_cast<uint8_t>(index >> 8));
      body.push_back(static_cast<uint8_t>(index));
    }
    for (std::size_t i = 0; i < 2 * beams; ++i) body.push_back(0x10);
    return body;
  };
  const auto good = decode_body(body_of(4, 1, 9, 3));
  ASSERT_TRUE(good.has_value());
  EXPECT_EQ(good->last(), 9);
  for (const int last : {10, 11, 12}) {
    EXPECT_FALSE(decode_body(body_of(4, 1, last, 3)).has_value()) << last;  // between two beams
  }
  EXPECT_FALSE(decode_body(body_of(4, 1, 9, 2)).has_value());
  EXPECT_FALSE(decode_body(body_of(4, 1, 9, 4)).has_value());
  EXPECT_FALSE(decode_body(body_of(0, 1, 9, 3)).has_value());
  EXPECT_FALSE(decode_body(body_of(4, 0, 8, 3)).has_value());
  EXPECT_FALSE(decode_body(body_of(4, 9, 5, 0)).has_value());
  EXPECT_TRUE(decode_body(body_of(4, 521, 529, 3)).has_value());
  EXPECT_FALSE(decode_body(body_of(4, 522, 530, 3)).has_value());  // beyond the last
}

TEST(LeuzeCodec, OptionsPasswordAndFlags) {
  Telegram telegram = telegram_of({1000, 1002});
  telegram.options = {0x0B | kPasswordFollows, 0x84, 0x01};
  EXPECT_THAT(telegrams_in({encode_telegram(telegram)}), ::testing::ElementsAre(telegram));
  // The flag of bit 0 is no part of the range; with it, the checksum is another.
  Bytes flagged = encode_telegram(telegram_of({1000, 2000, 3000}));
  flagged[18] |= 1;
  flagged[flagged.size() - 4] ^= 1;
  EXPECT_EQ(telegrams_in({flagged})[0].values_mm[0], 1000);
  Telegram error;
  error.operation = kError;
  Bytes line = hex("00 00 53 11");
  line.push_back(0x53 ^ 0x11);
  EXPECT_EQ(telegrams_in({join({line, hex("00 00 00")})})[0].operation, kError);
}

TEST(LeuzeCodec, AnySplitAndResynchronizes) {
  std::mt19937 random(21);
  std::vector<Bytes> lines;
  std::vector<Bytes> messages;
  std::vector<Telegram> telegrams;
  for (uint32_t i = 0; i < 8; ++i) {
    Telegram telegram;
    telegram.scan_number = i * 256;
    for (int k = 0; k < 133; ++k) {
      // No pairs of zeros here: of those one lost makes its stuffed FF a value's byte, and neither
      // the length nor the xor can tell.
      telegram.values_mm.push_back(static_cast<uint16_t>((random() & 0xFFFE) | 0x0202));
    }
    telegrams.push_back(telegram);
    lines.push_back(encode_telegram(telegram));
    messages.push_back(lines.back());
  }
  EXPECT_EQ(telegrams_in(split_at_random(join(lines), random)), telegrams);
  expect_resynchronizes(
      lines, messages,
      [](const auto& chunks) {
        std::vector<Bytes> found;
        for (const Telegram& telegram : telegrams_in(chunks)) {
          found.push_back(encode_telegram(telegram));
        }
        return found;
      },
      400);
}

TEST(LeuzeCodec, ZerosAreStuffedInAnySplit) {
  std::mt19937 random(22);
  std::vector<Bytes> lines;
  std::vector<Telegram> telegrams;
  for (int i = 0; i < 50; ++i) {
    Telegram telegram;
    telegram.step = 1;
    for (int k = 0; k < 200; ++k) {
      telegram.values_mm.push_back(
          static_cast<uint16_t>(random() % 3 == 0 ? random() & 0xFFFE : 0));
    }
    telegrams.push_back(telegram);
    lines.push_back(encode_telegram(telegram));
  }
  EXPECT_EQ(telegrams_in(split_at_random(join(lines), random)), telegrams);
}

TEST(LeuzeCodec, ServiceBytes) {
  EXPECT_THAT(service_request(), ::testing::ElementsAre(1, 0, 0, 0));
  std::vector<float> ranges(kServiceBeams, 1.0f);
  ranges[1] = 2.5f;
  Bytes answer = encode_service_answer(ranges);
  EXPECT_EQ(answer.size(), 532u);
  EXPECT_EQ(Bytes(answer.begin(), answer.begin() + 8), hex("00 00 80 3F 00 00 20 40"));
  EXPECT_EQ(decode_service_answer(answer), ranges);
  answer[3] = 0x7F;
  answer[2] = 0xC0;  // not a number
  EXPECT_FALSE(decode_service_answer(answer).has_value());
  answer.pop_back();
  EXPECT_FALSE(decode_service_answer(answer).has_value());
}

TEST(LeuzeGeometry, AsInTheTheses) {
  const double deg = 3.14159265358979 / 180.0;
  EXPECT_NEAR(LeuzeGeometry{}.bearing_rad(1), 95.04 * deg, 1e-9);
  EXPECT_NEAR(thesis_a_geometry().bearing_rad(1), -95.0 * deg, 1e-9);
  EXPECT_NEAR(thesis_a_geometry().bearing_rad(529), 95.0 * deg, 1e-9);
}

// Two millimetres are the unit (bit 0 is a flag): half of it, and the test world's 3.5 m/s.
constexpr double kToleranceM = 0.001 + 0.0005;

TEST(LeuzeDriver, MeasuresAtAnySpeedAndDropsWhatTheLineCannotCarry) {
  struct Case {
    int baud, wanted, step;
    double period_s;
  };
  // 287 bytes take 49.8 ms at 57600: each second sweep.
  for (const Case& one : {Case{57'600, 57'600, 4, 0.08}, Case{115'200, 57'600, 4, 0.04},
                          Case{38'400, 115'200, 2, 0.16}}) {
    LeuzeEmulatorOptions device;
    device.baud = one.baud;
    device.step = one.step;
    device.geometry.scale = 1.077;
    LeuzeEmulator emulator(test_world, device);
    SimulatedLine line(emulator);
    const auto stream = line.open({9600});
    LeuzeOptions options;
    options.baud = one.wanted;
    options.geometry.scale = 1.077;
    LeuzeDriver driver(*stream, options, [&] { return line.now(); });
    const auto scans = step_until(driver, line, 6.0, have(10));
    ASSERT_EQ(scans.size(), 10u) << driver.state();
    EXPECT_NEAR((scans[9].scan.utime - scans[8].scan.utime).seconds(), one.period_s, 1e-4);
    for (const ArrivedScan& arrived : scans) {
      EXPECT_EQ(arrived.scan.size(), one.step == 4 ? 133u : 265u);
      EXPECT_LT(worst_range_error_m(arrived.scan), kToleranceM);
    }
  }
}

TEST(LeuzeDriver, IsBackAfterPlugSilenceAndFlood) {
  LeuzeEmulator emulator(test_world, {});
  SimulatedLine line(emulator);
  auto stream = line.open({57'600});
  const auto clock = [&] { return line.now(); };
  auto driver = std::make_unique<LeuzeDriver>(*stream, LeuzeOptions{}, clock);
  ASSERT_EQ(step_until(*driver, line, 2.0, have(3)).size(), 3u);
  line.at(line.now() + Duration::from_us(30'000), [&] { line.unplug(); });
  EXPECT_THROW(step_until(*driver, line, 2.0, have(100)), StreamLost);
  line.plug_in();
  stream = line.open({57'600});
  driver = std::make_unique<LeuzeDriver>(*stream, LeuzeOptions{}, clock);
  ASSERT_EQ(step_until(*driver, line, 1.0, have(1)).size(), 1u);
  std::mt19937 random(4);
  line.set_tamper_to_client([&](Bytes& bytes) {
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  });
  EXPECT_TRUE(step_until(*driver, line, 3.0, have(1)).empty());
  EXPECT_THAT(driver->state(), HasSubstr("waiting for the laser"));
  line.set_tamper_to_client([](Bytes& bytes) { bytes.clear(); });
  EXPECT_TRUE(step_until(*driver, line, 1.0, have(1)).empty());
  line.set_tamper_to_client({});
  ASSERT_EQ(step_until(*driver, line, 5.0, have(1)).size(), 1u);
}

TEST(LeuzeService, OneConnectionAScan) {
  LeuzeServiceEmulator emulator(test_world, thesis_a_geometry());
  SimulatedLine line(emulator, false);
  LeuzeOptions options;
  options.service = true;
  options.geometry = thesis_a_geometry();
  options.poll_s = 0.0;
  int connections = 0;
  ConnectionPerRequest stream([&] {
    ++connections;
    return line.open({});
  });
  LeuzeServiceDriver driver(stream, options, [&] { return line.now(); });
  for (int i = 0; i < 5; ++i) {
    line.wait(Duration::from_us(17'000));
    const auto scans = step_until(driver, line, 1.0, have(1));
    ASSERT_EQ(scans.size(), 1u);
    EXPECT_EQ(scans[0].scan.size(), 133u);
    EXPECT_NEAR((scans[0].scan.utime - emulator.last_first_beam()).seconds(), 0.0, 0.0201);
    LaserScan scan = scans[0].scan;
    scan.utime = emulator.last_first_beam();
    EXPECT_LT(worst_range_error_m(scan), kToleranceM);
  }
  EXPECT_EQ(connections, 5);
  line.unplug();
  line.wait(Duration::from_us(10'000));
  EXPECT_THROW(driver.step(), StreamLost);
}

}  // namespace
}  // namespace marco::drivers::leuze
