// The emulator as other hosts meet it.
#include <gmock/gmock.h>

#include "simulator/devices/sick/emulator.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::sick {
namespace {

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

TEST(SickEmulator, AnswersItsOwnAddressAndTheOneOfAll) {
  SickEmulatorOptions options;
  options.address = 0x83;
  SickEmulator emulator(test_world, options);
  Utime now = Utime::from_us(1'000'000'000);
  emulator.on_connection(true, now);
  for (const uint8_t address : Bytes{0, 3}) {
    const Bytes answer = answer_to(emulator, now, encode_telegram(address, Bytes{kGetType}));
    ASSERT_GT(answer.size(), 3U) << int{address};
    EXPECT_EQ(answer[0], kAck);
    EXPECT_EQ(answer[2], 0x83);  // behind the STX
  }
  for (const uint8_t address : Bytes{1, 2, 4, 0x7F}) {
    EXPECT_TRUE(answer_to(emulator, now, encode_telegram(address, Bytes{kGetType})).empty())
        << int{address};
  }
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
