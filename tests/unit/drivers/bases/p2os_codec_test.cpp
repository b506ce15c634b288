#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "drivers/p2os/codec.hpp"
#include "drivers/p2os/models.hpp"

namespace marco::drivers::p2os {
namespace {

Bytes hex(const std::string& text) {
  std::istringstream in(text);
  Bytes bytes;
  for (std::string byte; in >> byte;) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(byte, nullptr, 16)));
  }
  return bytes;
}

std::vector<Bytes> parse_all(PacketParser& parser, std::span<const uint8_t> bytes) {
  std::vector<Bytes> packets;
  parser.push(bytes);
  while (auto payload = parser.next()) packets.push_back(std::move(*payload));
  return packets;
}

TEST(P2osCodec, CommandsAreTheVectorsBothWays) {
  const struct {
    CommandId id;
    std::optional<int> value;
    const char* bytes;
  } vectors[] = {
      {CommandId::pulse, std::nullopt, "FA FB 03 00 00 00"},
      {CommandId::open, std::nullopt, "FA FB 03 01 00 01"},
      {CommandId::close, std::nullopt, "FA FB 03 02 00 02"},
      {CommandId::open, 1, "FA FB 06 01 3B 01 00 02 3B"},
      {CommandId::enable, 1, "FA FB 06 04 3B 01 00 05 3B"},
      {CommandId::sonar, 1, "FA FB 06 1C 3B 01 00 1D 3B"},
      {CommandId::velocity, 200, "FA FB 06 0B 3B C8 00 D3 3B"},
      {CommandId::velocity, -200, "FA FB 06 0B 1B C8 00 D3 1B"},
      {CommandId::rotation_velocity, 30, "FA FB 06 15 3B 1E 00 33 3B"},
      {CommandId::rotation_velocity, -30, "FA FB 06 15 1B 1E 00 33 1B"},
      {CommandId::set_max_velocity, 500, "FA FB 06 06 3B F4 01 FA 3C"},
      {CommandId::set_acceleration, 300, "FA FB 06 05 3B 2C 01 31 3C"},
      {CommandId::set_max_rate, 100, "FA FB 06 0A 3B 64 00 6E 3B"},
      {CommandId::set_rotation_acceleration, 100, "FA FB 06 17 3B 64 00 7B 3B"},
      {CommandId::set_origin, std::nullopt, "FA FB 03 07 00 07"},
      {CommandId::stop, std::nullopt, "FA FB 03 1D 00 1D"},
      {CommandId::emergency_stop, std::nullopt, "FA FB 03 37 00 37"},
      {CommandId::move, 1000, "FA FB 06 08 3B E8 03 F0 3E"},
      {CommandId::heading, 90, "FA FB 06 0C 3B 5A 00 66 3B"},
      {CommandId::wheel_velocities, 10 << 8 | 10, "FA FB 06 20 3B 0A 0A 2A 45"},
      {CommandId::close, 1, "FA FB 06 02 3B 01 00 03 3B"},
      {CommandId::config, 1, "FA FB 06 12 3B 01 00 13 3B"},
  };
  for (const auto& vector : vectors) {
    const Command command{vector.id, vector.value, ""};
    EXPECT_EQ(encode_command(command), hex(vector.bytes)) << vector.bytes;
    PacketParser parser;
    const auto packets = parse_all(parser, hex(vector.bytes));
    ASSERT_EQ(packets.size(), 1U) << vector.bytes;
    EXPECT_EQ(decode_command(packets[0]), command) << vector.bytes;
  }
}

TEST(P2osCodec, TheNameIsTheVector) {
  const RobotName name{"MARCO", "Pioneer", "P2DX"};
  const Bytes bytes =
      hex("FA FB 16 02 4D 41 52 43 4F 00 50 69 6F 6E 65 65 72 00 50 32 44 58 00 4F 18");
  EXPECT_EQ(encode_name(name), bytes);
  PacketParser parser;
  EXPECT_EQ(decode_name(parse_all(parser, bytes).at(0)), name);
  EXPECT_FALSE(decode_name(hex("02 41 42 00 43")));
}

TEST(P2osCodec, InformationPacketsAreTheVectors) {
  Sip standing;
  standing.x = 119;
  standing.heading = 1024;
  standing.battery = 126;
  standing.flags = 0x1F;
  standing.sonars = {{0, 3731}, {1, 5000}};
  const Bytes first = hex(
      "FA FB 21 32 77 00 00 00 00 04 00 00 00 00 7E 00 00 00 00 1F 00 00 02 00 93 0E 01 88 13 00 "
      "00 00 FF 00 ED 9D");
  EXPECT_EQ(encode_sip(standing), first);
  Sip moving;
  moving.moving = true;
  moving.x = 238;
  moving.y = 0x7FF4;
  moving.left_speed = moving.right_speed = 200;
  moving.battery = 125;
  moving.flags = 0x1F;
  const Bytes second = hex(
      "FA FB 1B 33 EE 00 F4 7F 00 00 C8 00 C8 00 7D 00 00 00 00 1F 00 00 00 00 00 00 FF 00 D5 EE");
  EXPECT_EQ(encode_sip(moving), second);
  PacketParser parser;
  EXPECT_EQ(decode_sip(parse_all(parser, first).at(0)), standing);
  EXPECT_EQ(decode_sip(parse_all(parser, second).at(0)), moving);
  // 119 units of 0.84 mm, 1024 of 4096 of a turn, 3731 of 0.268 mm.
  EXPECT_NEAR(119 * model_of("P2DX")->mm_per_distance, 100.0, 0.1);
  EXPECT_NEAR(rad_to_deg(1024 * kRadPerHeading), 90.0, 1e-9);
  EXPECT_NEAR(3731 * model_of("p2dx")->mm_per_range, 1000.0, 0.2);
  EXPECT_FALSE(model_of("p9xx"));
  EXPECT_FALSE(model_of("-lms500"));
}

TEST(P2osCodec, CutInformationPacketsAreNone) {
  Sip sip;
  sip.heading = -1024;
  sip.sonars = {{3, 1000}, {4, 2000}};
  const Bytes packet = encode_sip(sip);
  const std::vector<uint8_t> payload(packet.begin() + 3, packet.end() - 2);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    // Of its own memory, so that a byte too far is seen by the sanitizers, too.
    const Bytes cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decode_sip(cut).has_value()) << size;
  }
  EXPECT_EQ(decode_sip(payload), sip);
  EXPECT_LT(decode_sip(payload)->heading, 0);
}

Sip random_sip(std::mt19937& random) {
  Sip sip;
  sip.moving = random() % 2 == 0;
  sip.x = random() & 0x7FFF;
  sip.y = random() & 0x7FFF;
  sip.heading = static_cast<int16_t>(random());
  sip.left_speed = static_cast<int16_t>(random());
  sip.right_speed = static_cast<int16_t>(random());
  sip.battery = static_cast<uint8_t>(random());
  sip.flags = static_cast<uint16_t>(random());
  for (std::size_t i = random() % 17; i > 0; --i) {
    sip.sonars.push_back({static_cast<uint8_t>(i), static_cast<uint16_t>(random())});
  }
  return sip;
}

TEST(P2osCodec, AnyPacketReadsBackInAnySplit) {
  std::mt19937 random(5);
  PacketParser parser;
  for (int i = 0; i < 500; ++i) {
    const Sip sip = random_sip(random);
    const Bytes bytes = encode_sip(sip);
    const std::size_t cut = random() % bytes.size();
    auto packets = parse_all(parser, std::span(bytes).first(cut));
    EXPECT_TRUE(packets.empty());
    packets = parse_all(parser, std::span(bytes).subspan(cut));
    ASSERT_EQ(packets.size(), 1U);
    EXPECT_EQ(decode_sip(packets[0]), sip);
  }
  EXPECT_EQ(parser.garbage_bytes() + parser.bad_checksums(), 0);
}

TEST(P2osCodec, GarbageCostsAtMostThePacketsItTouches) {
  std::mt19937 random(6);
  for (int round = 0; round < 300; ++round) {
    PacketParser parser;
    Bytes stream;
    for (std::size_t i = random() % 40; i > 0; --i)
      stream.push_back(static_cast<uint8_t>(random()));
    std::vector<Bytes> sent;
    for (int i = 0; i < 12; ++i) {
      Bytes packet = encode_sip(random_sip(random));
      sent.push_back(Bytes(packet.begin() + 3, packet.end() - 2));
      if (i == 2) {  // one of them is flipped, shortened or has a byte twice
        const std::size_t at = random() % packet.size();
        const auto kind = random() % 3;
        if (kind == 0) packet[at] = static_cast<uint8_t>(packet[at] ^ (1U << (random() % 8)));
        if (kind == 1) packet.erase(packet.begin() + static_cast<std::ptrdiff_t>(at));
        if (kind == 2) packet.insert(packet.begin() + static_cast<std::ptrdiff_t>(at), packet[at]);
        sent.pop_back();
      }
      stream.insert(stream.end(), packet.begin(), packet.end());
    }
    const auto got = parse_all(parser, stream);
    // Garbage may look like the head of a packet of up to 202 bytes and hide what it covers only
    // until its sum is found wrong: nothing sound is lost, nothing unsound delivered.
    int found = 0;
    for (const Bytes& payload : got) {
      found += std::find(sent.begin(), sent.end(), payload) != sent.end() ? 1 : 0;
    }
    EXPECT_GE(found, 9) << round;
    EXPECT_LE(got.size(), static_cast<std::size_t>(found) + 1) << round;
  }
}

}  // namespace
}  // namespace marco::drivers::p2os
