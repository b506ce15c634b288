#include <gmock/gmock.h>

#include "drivers/ydlidar/answer_parser.hpp"
#include "tests/unit/drivers/lasers_support.hpp"

namespace marco::drivers::ydlidar {
namespace {

std::vector<Answer> answers_in(const std::string& text) {
  AnswerParser parser;
  parser.push(hex(text));
  std::vector<Answer> answers;
  while (auto answer = parser.next()) answers.push_back(std::move(*answer));
  return answers;
}

TEST(YdlidarCodec, RequestsAndHeaders) {
  EXPECT_EQ(encode_request(kScan), hex("A5 60"));
  EXPECT_EQ(encode_request(kStop), hex("A5 65"));
  EXPECT_EQ(encode_request(kGetInfo), hex("A5 90"));
  EXPECT_EQ(encode_request(kGetHealth), hex("A5 91"));
  EXPECT_EQ(encode_header(20, false, kInfo), hex("A5 5A 14 00 00 00 04"));
  EXPECT_EQ(encode_header(3, false, kHealth), hex("A5 5A 03 00 00 00 06"));
  EXPECT_EQ(encode_header(5, true, kPackets), hex("A5 5A 05 00 00 40 81"));
}

// An X4's, from a bench note: firmware 1.10, hardware 1.
TEST(YdlidarCodec, InfoOfAnX4) {
  const auto answers = answers_in(
      "00 A5 A5 5A 14 00 00 00 04 06 0A 01 01 02 00 02 00 00 00 06 02 01 00 00 00 00 00 00 02");
  ASSERT_EQ(answers.size(), 1u);
  const DeviceInfo info = decode_info(answers[0].data);
  EXPECT_EQ(model_name(info.model), "X4");
  EXPECT_EQ(info.firmware_major, 1);
  EXPECT_EQ(info.firmware_minor, 10);
  EXPECT_EQ(info.hardware, 1);
}

TEST(YdlidarCodec, PacketsOfTheManual) {
  const auto zero = answers_in("AA 55 01 01 53 AE 53 AE AB 54 00 00");
  ASSERT_EQ(zero.size(), 1u);
  EXPECT_TRUE(zero[0].packet.turn_start);
  EXPECT_NEAR(sample_angle_deg(zero[0].packet, 0), 348.64, 0.005);
  EXPECT_EQ(zero[0].packet.samples[0].range_mm, 0.0);

  const auto turning = answers_in("AA 55 8D 01 21 00 21 00 27 54 00 00");
  ASSERT_EQ(turning.size(), 1u);
  EXPECT_EQ(turning[0].packet.frequency_dhz, 70);
  EXPECT_TRUE(turning[0].packet.turn_start);
}

TEST(YdlidarCodec, SamplesAndTheirAngles) {
  const std::string bytes = "AA 55 00 03 01 2D 01 2E 0A 27 A0 0F 00 00 00 7D";
  const auto answers = answers_in(bytes);
  ASSERT_EQ(answers.size(), 1u);
  const Packet& packet = answers[0].packet;
  const auto seen_at_deg = [&packet](std::size_t i) {
    return sample_angle_deg(packet, i) + angle_correction_deg(packet.samples[i].range_mm);
  };
  ASSERT_EQ(packet.samples.size(), 3u);
  EXPECT_EQ(packet.samples[0].range_mm, 1000.0);
  EXPECT_NEAR(seen_at_deg(0), 83.2378, 1e-4);
  EXPECT_EQ(packet.samples[1].range_mm, 0.0);
  EXPECT_NEAR(seen_at_deg(1), 91.0, 1e-4);
  EXPECT_EQ(packet.samples[2].range_mm, 8000.0);
  EXPECT_NEAR(seen_at_deg(2), 84.1626, 1e-4);
  EXPECT_EQ(encode_packet(packet, SampleForm::range), hex(bytes));
}

TEST(YdlidarCodec, IntensityAndStamp) {
  const std::string bytes = "AA 55 00 01 01 2D 01 2D 5A 5B 50 A0 0F";
  // A stamp stands between packets of newer firmware, and is no gap.
  const auto answers = answers_in(bytes + " AA 66 6F 40 E2 01 00 00 " + bytes);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].form, SampleForm::intensity);
  EXPECT_EQ(answers[0].packet.samples[0], (Sample{1000.0, 0x50}));
  EXPECT_TRUE(answers[1].continuous);
  EXPECT_EQ(encode_packet(answers[0].packet, SampleForm::intensity), hex(bytes));
}

TEST(YdlidarCodec, ReadsBackEachForm) {
  Packet packet;
  packet.first_q6 = 100;
  packet.last_q6 = 130;
  for (const SampleForm form :
       {SampleForm::range, SampleForm::intensity, SampleForm::wide_intensity}) {
    packet.samples = {{1234.0, form == SampleForm::range ? 0 : 77}, {0.0, 0}};
    const Bytes bytes = encode_packet(packet, form);
    ASSERT_EQ(packet_size(bytes, form), bytes.size());
    const auto again = decode_packet(bytes, form);
    ASSERT_TRUE(again.has_value());
    EXPECT_EQ(again->samples, packet.samples);
  }
  packet.samples.clear();
  EXPECT_THROW(encode_packet(packet, SampleForm::range), std::invalid_argument);
}

class YdlidarForms : public ::testing::TestWithParam<SampleForm> {};

// Known as soon as some packets came, and then kept.
TEST_P(YdlidarForms, PacketsResynchronizeInAnySplit) {
  std::mt19937 random(31);
  const auto packet_of = [&](std::size_t count) {
    Packet packet;
    packet.first_q6 = static_cast<int>(random() % (360 * 64));
    packet.last_q6 = static_cast<int>(random() % (360 * 64));
    for (std::size_t i = 0; i < count; ++i) {
      const auto intensity = static_cast<int>(1 + random() % 255);
      packet.samples.push_back({static_cast<double>(1 + random() % 16'000),
                                GetParam() == SampleForm::range ? 0 : intensity});
    }
    return encode_packet(packet, GetParam());
  };
  std::vector<Bytes> first, telegrams;
  for (int i = 0; i < 5; ++i) first.push_back(packet_of(10));
  for (int i = 0; i < 8; ++i) telegrams.push_back(packet_of(5 + random() % 36));
  const auto parse = [&](const std::vector<Bytes>& chunks) {
    AnswerParser parser;
    parser.push(join(first));
    while (parser.next()) {
    }
    std::vector<Bytes> found;
    for (const Bytes& chunk : chunks) {
      parser.push(chunk);
      while (const auto answer = parser.next()) {
        if (answer->kind == kPackets) found.push_back(encode_packet(answer->packet, answer->form));
      }
    }
    return found;
  };
  EXPECT_EQ(parse(split_at_random(join(telegrams), random)), telegrams);
  // A byte doubled or cut off makes the next packet's first bytes part of this one.
  expect_resynchronizes(telegrams, telegrams, parse, 400);
}

// Another laser on the same line, or a form that was taken by mistake.
TEST(YdlidarParser, AFormThatFitsNoLongerIsGivenUp) {
  Packet packet;
  packet.samples.assign(20, {1000.0, 7});
  AnswerParser parser;
  const auto forms_of = [&](SampleForm form, int packets) {
    for (int i = 0; i < packets; ++i) parser.push(encode_packet(packet, form));
    int count = 0;
    while (const auto answer = parser.next()) count += answer->form == form ? 1 : 0;
    return count;
  };
  EXPECT_EQ(forms_of(SampleForm::intensity, 10), 10);
  EXPECT_GT(forms_of(SampleForm::range, 40), 20);
}

INSTANTIATE_TEST_SUITE_P(Forms,
                         YdlidarForms,
                         ::testing::Values(SampleForm::range,
                                           SampleForm::intensity,
                                           SampleForm::wide_intensity));

}  // namespace
}  // namespace marco::drivers::ydlidar
