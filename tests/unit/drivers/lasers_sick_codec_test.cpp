#include <gmock/gmock.h>

#include "drivers/sick/codec.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::sick {
namespace {

using ::testing::ElementsAreArray;
using Side = TelegramParser::Side;

struct Vector {
  const char* name;
  Bytes built;
  const char* line;
};

Bytes zeros(int count) { return Bytes(static_cast<std::size_t>(count), 0); }

Bytes configuration_payload(Bytes head, int mode, Unit unit) {
  Configuration configuration;
  configuration.bytes[3] = 2;
  configuration.set_measuring(mode, unit);
  head.insert(head.end(), configuration.bytes.begin(), configuration.bytes.end());
  return head;
}

Bytes text(uint8_t code, const std::string& words) {
  Bytes payload{code};
  payload.insert(payload.end(), words.begin(), words.end());
  return payload;
}

// All of devices.md 1.5. The long lines of zeros are written as a count.
std::vector<Vector> requests() {
  return {
      {"reset", encode_request(Bytes{kReset}), "02 00 01 00 10 34 12"},
      {"status", encode_request(Bytes{kGetStatus}), "02 00 01 00 31 15 12"},
      {"errors", encode_request(Bytes{kGetErrors}), "02 00 01 00 32 16 12"},
      {"type", encode_request(Bytes{kGetType}), "02 00 01 00 3A 1E 12"},
      {"get config", encode_request(Bytes{kGetConfiguration}), "02 00 01 00 74 50 12"},
      {"one scan", encode_request(Bytes{kGetValues, 1}), "02 00 02 00 30 01 31 18"},
      {"continuous", set_mode_request(kContinuous), "02 00 02 00 20 24 34 08"},
      {"on request", set_mode_request(kOnRequest), "02 00 02 00 20 25 35 08"},
      {"38400", set_mode_request(*mode_of_baud(38400)), "02 00 02 00 20 40 50 08"},
      {"19200", set_mode_request(*mode_of_baud(19200)), "02 00 02 00 20 41 51 08"},
      {"9600", set_mode_request(*mode_of_baud(9600)), "02 00 02 00 20 42 52 08"},
      {"500000", set_mode_request(*mode_of_baud(500000)), "02 00 02 00 20 48 58 08"},
      {"installation", installation_request(), "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5"},
      {"180/1.00", set_variant_request(180, 100), "02 00 05 00 3B B4 00 64 00 97 49"},
      {"180/0.50", set_variant_request(180, 50), "02 00 05 00 3B B4 00 32 00 3B 1F"},
      {"100/1.00", set_variant_request(100, 100), "02 00 05 00 3B 64 00 64 00 1D 0F"},
      {"100/0.50", set_variant_request(100, 50), "02 00 05 00 3B 64 00 32 00 B1 59"},
      {"100/0.25", set_variant_request(100, 25), "02 00 05 00 3B 64 00 19 00 E7 72"},
      {"partial scans", set_mode_request(kPartialScans), "02 00 02 00 20 2A 3A 08"},
      {"sub-range", encode_request(Bytes{kSetMode, kSubRange, 1, 0, 0xB5, 0}),
       "02 00 06 00 20 27 01 00 B5 00 12 09"},
  };
}

std::vector<Vector> replies() {
  const auto at81 = [](const Bytes& payload) { return encode_reply(payload, kHealthy, 0x81); };
  MeasuredValues cm{Unit::cm, false, 0, {100, 200, 0x1FFF, 300 | 0x2000}, {}, {}, 0, {}};
  MeasuredValues mm{Unit::mm, false, 0, {1000, 2000, 32759, 3000 | 0x8000}, {}, {}, 0, {}};
  MeasuredValues partial{Unit::mm, true, 2, {500, 501, 502}, {}, {}, 0, {}};
  return {
      {"mode ok", encode_reply(Bytes{0xA0, 0}), "02 80 03 00 A0 00 10 16 0A"},
      {"mode ok at 81", at81(Bytes{0xA0, 0}), "02 81 03 00 A0 00 10 36 1A"},
      {"mode refused", encode_reply(Bytes{0xA0, 1}), "02 80 03 00 A0 01 10 14 0B"},
      {"rejected", encode_reply(Bytes{0x92}), "02 80 02 00 92 10 7F 33"},
      {"variant ok", encode_reply(Bytes{0xBB, 1, 0xB4, 0, 0x32, 0}),
       "02 80 07 00 BB 01 B4 00 32 00 10 03 9D"},
      {"variant ok at 81", at81(Bytes{0xBB, 1, 0x64, 0, 0x64, 0}),
       "02 81 07 00 BB 01 64 00 64 00 10 4A 3F"},
      {"variant refused", encode_reply(Bytes{0xBB, 0, 0xB4, 0, 0x32, 0}),
       "02 80 07 00 BB 00 B4 00 32 00 10 23 8D"},
      {"type", encode_reply(text(0xBA, "LMS200;30106;V02.30")),
       "02 80 15 00 BA 4C 4D 53 32 30 30 3B 33 30 31 30 36 3B 56 30 32 2E 33 30 10 7B 43"},
      {"power-on", encode_reply(text(0x90, "LMS200;30106;V02.30 ")),
       "02 80 16 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 3B 56 30 32 2E 33 30 20 10 2B 7C"},
      {"power-on warming", encode_reply(text(0x90, "LMS200;301063;V02.06 "), 0x13, 0x81),
       "02 81 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 30 36 20 13 64 5A"},
      {"reset accepted", encode_reply(Bytes{0x91}), "02 80 02 00 91 10 79 30"},
      {"no errors", encode_reply(Bytes{0xB2}), "02 80 02 00 B2 10 3F 13"},
      {"cm values", encode_reply(encode_values(cm)),
       "02 80 0C 00 B0 04 00 64 00 C8 00 FF 1F 2C 21 10 EC DB"},
      {"mm values", encode_reply(encode_values(mm)),
       "02 80 0C 00 B0 04 40 E8 03 D0 07 F7 7F B8 8B 10 16 22"},
      {"partial", encode_reply(encode_values(partial)),
       "02 80 0A 00 B0 03 70 F4 01 F5 01 F6 01 10 09 B0"},
  };
}

std::vector<Bytes> payloads(Side side, const std::vector<Bytes>& chunks) {
  TelegramParser parser(side);
  std::vector<Bytes> found;
  const auto drain = [&] {
    while (const auto event = parser.next()) {
      if (event->kind != Event::Kind::telegram) continue;
      found.emplace_back(event->payload.begin(), event->payload.end());
    }
  };
  for (const Bytes& chunk : chunks) {
    parser.push(chunk);
    drain();
  }
  while (parser.waiting()) {
    parser.give_up_waiting();
    drain();
  }
  return found;
}

Bytes payload_of(const Bytes& telegram) { return {telegram.begin() + 4, telegram.end() - 2}; }

// The event borrows from the parser, kept alive here.
struct Parsed {
  explicit Parsed(const Bytes& telegram) : parser(Side::laser) {
    parser.push(telegram);
    event = parser.next().value();
  }
  TelegramParser parser;
  Event event;
};

TEST(SickCodec, EveryVectorIsWrittenAsPrinted) {
  for (const Vector& one : requests()) EXPECT_EQ(one.built, hex(one.line)) << one.name;
  for (const Vector& one : replies()) EXPECT_EQ(one.built, hex(one.line)) << one.name;
}

TEST(SickCodec, EveryVectorIsReadBack) {
  for (const Vector& one : requests()) {
    EXPECT_THAT(payloads(Side::host, {hex(one.line)}), ElementsAreArray({payload_of(one.built)}))
        << one.name;
  }
  for (const Vector& one : replies()) {
    EXPECT_THAT(payloads(Side::laser, {hex(one.line)}), ElementsAreArray({payload_of(one.built)}))
        << one.name;
  }
}

TEST(SickCodec, ConfigurationVectors) {
  const auto with_ends = [](const char* head, int zero_count, const char* tail) {
    return join({hex(head), zeros(zero_count), hex(tail)});
  };
  const Bytes read = encode_reply(configuration_payload({0xF4}, 0, Unit::cm));
  EXPECT_EQ(read, with_ends("02 80 24 00 F4 00 00 00 02", 30, "10 76 E7"));
  EXPECT_EQ(encode_reply(configuration_payload({0xF7, 1}, 0, Unit::cm)),
            with_ends("02 80 25 00 F7 01 00 00 00 02", 30, "10 8F 66"));
  EXPECT_EQ(encode_reply(configuration_payload({0xF7, 1}, 6, Unit::mm)),
            with_ends("02 80 25 00 F7 01 00 00 00 02 00 06 01", 27, "10 A0 01"));
  const Parsed parsed(read);
  Configuration configuration = decode_configuration(parsed.event).value();
  EXPECT_EQ(configuration.measuring_mode(), 0);
  EXPECT_EQ(set_configuration_request(configuration),
            with_ends("02 00 23 00 77 00 00 00 02", 30, "34 86"));
  configuration.set_measuring(6, Unit::mm);
  EXPECT_EQ(set_configuration_request(configuration),
            with_ends("02 00 23 00 77 00 00 00 02 00 06 01", 27, "A1 75"));
  Configuration old{join({hex("00 00 00 00 00 0D 00 00 00 02 02"), zeros(21)})};
  EXPECT_EQ(set_configuration_request(old),
            with_ends("02 00 21 00 77 00 00 00 00 00 0D 00 00 00 02 02", 21, "20 CB"));
}

TEST(SickCodec, LongScansByRule) {
  struct Case {
    int beams, first;
    Unit unit;
    const char *head, *tail;
    std::size_t size;
  };
  for (const Case& one :
       {Case{361, 1000, Unit::mm, "02 80 D6 02 B0 69 41 E8 03", "10 86 0C", 732},
        Case{181, 100, Unit::cm, "02 80 6E 01 B0 B5 00 64 00", "10 BB 6D", 372},
        Case{401, 100, Unit::cm, "02 80 26 03 B0 91 01 64 00", "10 CA 98", 812}}) {
    MeasuredValues values;
    values.unit = one.unit;
    for (int i = 0; i < one.beams; ++i) {
      values.words.push_back(static_cast<uint16_t>(one.first + i));
    }
    const Bytes telegram = encode_reply(encode_values(values));
    EXPECT_EQ(telegram.size(), one.size);
    EXPECT_EQ(Bytes(telegram.begin(), telegram.begin() + 9), hex(one.head));
    EXPECT_EQ(Bytes(telegram.end() - 3, telegram.end()), hex(one.tail));
    const Parsed parsed(telegram);
    EXPECT_EQ(decode_values(parsed.event).value().words, values.words);
  }
}

TEST(SickCodec, StatusBlock) {
  StatusReport report;
  report.firmware = "V02.30";
  report.boot_firmware = "V01.10";
  report.resolution_cdeg = 50;
  const Bytes telegram = encode_reply(encode_status(report));
  EXPECT_EQ(telegram.size(), 160u);
  EXPECT_EQ(Bytes(telegram.begin(), telegram.begin() + 5), hex("02 80 9A 00 B1"));
  EXPECT_EQ(Bytes(telegram.end() - 3, telegram.end()), hex("10 8C 9F"));
  const Parsed parsed(telegram);
  const StatusReport read = decode_status(parsed.event).value();
  EXPECT_EQ(read.firmware, "V02.30");
  EXPECT_EQ(read.boot_firmware, "V01.10");
  EXPECT_EQ(read.angle_deg, 180);
  EXPECT_EQ(read.resolution_cdeg, 50);
  EXPECT_EQ(read.baud, 9600);
  EXPECT_EQ(read.mode, kOnRequest);
  // The manual's layout lacks six bytes behind the error flag.
  Bytes old = encode_status(report);
  old.erase(old.begin() + 10, old.begin() + 16);
  const Parsed parsed_old(encode_reply(old));
  EXPECT_EQ(decode_status(parsed_old.event).value().resolution_cdeg, 50);
  EXPECT_EQ(decode_status(parsed_old.event).value().boot_firmware, "V01.10");
}

TEST(SickCodec, SubRangeAndIndexBytes) {
  MeasuredValues values{Unit::mm, false, 0, {1, 2, 3}, {7, 8}, {{5, 7}}, 0, {}};
  const Parsed parsed(encode_reply(encode_values(values)));
  const MeasuredValues read = decode_values(parsed.event).value();
  EXPECT_EQ(read.words, values.words);
  EXPECT_EQ(read.indices, values.indices);
  EXPECT_EQ(read.sub_range, values.sub_range);
}

TEST(SickCodec, MeansAndReflectivities) {
  // By sicktoolbox's reading: B6 n count values; BF n first last count values;
  // C4 count values, count first last levels.
  const auto both_ways = [](const MeasuredValues& values, const char* payload) {
    EXPECT_EQ(encode_values(values), hex(payload));
    const Parsed parsed(encode_reply(encode_values(values)));
    const MeasuredValues read = decode_values(parsed.event).value();
    EXPECT_EQ(read.words, values.words);
    EXPECT_EQ(read.samples, values.samples);
    EXPECT_EQ(read.sub_range, values.sub_range);
    EXPECT_EQ(read.reflectivity, values.reflectivity);
  };
  both_ways({Unit::mm, false, 0, {1, 2}, {}, {}, 5, {}}, "B6 05 02 40 01 00 02 00");
  both_ways({Unit::mm, false, 0, {1, 2}, {}, {{3, 4}}, 5, {}},
            "BF 05 03 00 04 00 02 40 01 00 02 00");
  both_ways({Unit::cm, false, 0, {1, 2, 3}, {}, {{2, 3}}, 0, {9, 8}},
            "C4 03 00 01 00 02 00 03 00 02 00 02 00 03 00 09 08");
  for (const char* cut : {"B6 05 02 40 01 00 02", "BF 05 03 00 04", "C4 01 00 01 00 05 00 01 00"}) {
    EXPECT_FALSE(decode_values(Parsed(encode_reply(hex(cut))).event).has_value()) << cut;
  }
}

TEST(SickCodec, RangesAndSpecialValuesByMode) {
  EXPECT_EQ(special_of(8182, range_rule(0)), std::nullopt);
  EXPECT_EQ(special_of(8183 | 0x2000, range_rule(0)), Special::beyond_range);
  EXPECT_EQ(special_of(8190, range_rule(1)), Special::dazzled);
  EXPECT_EQ(special_of(16381, range_rule(4)), Special::overflow);
  EXPECT_EQ(special_of(32763, range_rule(6)), Special::noise);
  EXPECT_EQ(special_of(32762, range_rule(6)), Special::read_error);
  EXPECT_EQ(special_of(32767, range_rule(6)), Special::no_echo);
  EXPECT_EQ(special_of(32760, range_rule(6)), Special::unknown);
  EXPECT_EQ(word_of(Special::beyond_range, range_rule(6)), 32759);
  EXPECT_EQ(word_of(Special::no_echo, range_rule(3)), 16383);
  EXPECT_EQ(range_rule(0x0F).distance_mask, 0xFFFF);
  EXPECT_THROW(range_rule(0x3F), std::invalid_argument);
}

TEST(SickCodec, RefusesACountThatContradictsTheLength) {
  const Parsed parsed(encode_reply(Bytes{0xB7, 1, 0, 9, 0, 4, 0, 1, 0, 2, 0}));
  EXPECT_FALSE(decode_values(parsed.event).has_value());
  EXPECT_THAT(payloads(Side::laser, {encode_reply(Bytes{0xB0, 4, 0, 1, 0, 2, 0})}),
              ::testing::IsEmpty());
}

TEST(SickParser, AckAndNakStandBetweenTelegrams) {
  TelegramParser parser(Side::laser);
  parser.push(join({{kAck}, encode_reply(Bytes{0xA0, 0x06}), {kNak}}));
  EXPECT_EQ(parser.next()->kind, Event::Kind::ack);
  const auto telegram = parser.next();
  EXPECT_EQ(telegram->kind, Event::Kind::telegram);
  EXPECT_EQ(telegram->bytes_after, 1u);
  EXPECT_EQ(parser.next()->kind, Event::Kind::nak);
  EXPECT_FALSE(parser.next().has_value());
  EXPECT_EQ(parser.garbage_bytes(), 0);
}

TEST(SickParser, FindsAnyTelegramsInAnySplit) {
  std::mt19937 random(3);
  std::vector<Bytes> telegrams;
  std::vector<Bytes> expected;
  for (int i = 0; i < 60; ++i) {
    MeasuredValues values;
    values.unit = Unit::mm;
    values.words.resize(random() % 402);
    for (uint16_t& word : values.words) word = static_cast<uint16_t>(random());
    telegrams.push_back(encode_reply(encode_values(values), static_cast<uint8_t>(random())));
    expected.push_back(payload_of(telegrams.back()));
  }
  EXPECT_EQ(payloads(Side::laser, split_at_random(join(telegrams), random)), expected);
}

TEST(SickParser, ResynchronizesWithinTwoTelegrams) {
  std::vector<Bytes> telegrams;
  std::vector<Bytes> expected;
  std::mt19937 random(5);
  for (int i = 0; i < 8; ++i) {
    MeasuredValues values;
    values.words.resize(101);
    // Values full of 02 and 06, which must not be taken for beginnings.
    for (uint16_t& word : values.words) word = random() % 3 == 0 ? 0x0202 : 0x0680;
    telegrams.push_back(encode_reply(encode_values(values)));
    expected.push_back(payload_of(telegrams.back()));
  }
  expect_resynchronizes(
      telegrams, expected, [](const auto& chunks) { return payloads(Side::laser, chunks); }, 400);
}

TEST(SickParser, CountsWhatItPassesOver) {
  TelegramParser parser(Side::laser);
  Bytes damaged = encode_reply(Bytes{0xA0, 0});
  damaged[5] ^= 1;
  parser.push(join({hex("FF FF FF"), damaged, encode_reply(Bytes{0xA0, 0})}));
  int good = 0;
  while (const auto event = parser.next()) good += event->kind == Event::Kind::telegram ? 1 : 0;
  EXPECT_EQ(good, 1);
  EXPECT_EQ(parser.bad_checksums(), 1);
  EXPECT_EQ(parser.garbage_bytes(), 3 + 9);
}

// The highest bit of an address says who speaks. A host that hears its own request (RS-422 with an
// echo) must not take it for a reply, nor the laser a reply for a request.
TEST(SickParser, TakesTelegramsOfTheOtherSideOnly) {
  for (const bool from_laser : {true, false}) {
    TelegramParser parser(from_laser ? TelegramParser::Side::laser : TelegramParser::Side::host);
    for (int address = 0; address < 256; ++address) {
      const Bytes telegram =
          encode_telegram(static_cast<uint8_t>(address), Bytes{kGetType | 0x80, 'L', kHealthy});
      parser.push(telegram);
      int telegrams = 0;
      while (const auto event = parser.next()) {
        if (event->kind != Event::Kind::telegram) continue;
        ++telegrams;
        EXPECT_EQ(event->address, address);
      }
      EXPECT_EQ(telegrams, (address >= 0x80) == from_laser ? 1 : 0) << address;
      parser.clear();
    }
  }
}

}  // namespace
}  // namespace marco::drivers::sick
