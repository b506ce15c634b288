#include "drivers/p2os/codec.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "drivers/p2os/packet_fields.hpp"
#include "drivers/transport/little_endian.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr uint8_t kHead1 = 0xFA, kHead2 = 0xFB;
constexpr uint8_t kPositiveArgument = 0x3B, kNegativeArgument = 0x1B, kText = 0x2B;
constexpr uint8_t kStanding = 0x32, kMoving = 0x33;
constexpr uint8_t kNamePacket = 2;

template <class Io, class Packet>
void sip_fields(Io& io, Packet& sip) {
  io.u15(sip.x);
  io.u15(sip.y);
  io.u16(sip.heading);
  io.u16(sip.left_speed);
  io.u16(sip.right_speed);
  io.u8(sip.battery);
  io.u8(sip.left_stall);
  io.u8(sip.right_stall);
  io.u16(sip.control);
  io.u16(sip.flags);
  io.u8(sip.compass);
  io.list(sip.sonars, [&io](auto& sonar) {
    io.u8(sonar.number);
    io.u16(sonar.range);
  });
  io.u16(sip.analog_port);
  io.u8(sip.analog);
  io.u8(sip.digital_in);
  io.u8(sip.digital_out);
}

}  // namespace

uint16_t checksum(std::span<const uint8_t> payload) {
  unsigned sum = 0;
  std::size_t i = 0;
  for (; i + 1 < payload.size(); i += 2)
    sum += static_cast<unsigned>(payload[i] << 8 | payload[i + 1]);
  sum &= 0xFFFF;
  if (i < payload.size()) sum ^= payload[i];
  return static_cast<uint16_t>(sum);
}

Bytes encode_packet(std::span<const uint8_t> payload) {
  require(!payload.empty() && payload.size() <= kMaxPayload, "a packet carries 1 to 200 bytes");
  Bytes packet{kHead1, kHead2, static_cast<uint8_t>(payload.size() + 2)};
  packet.insert(packet.end(), payload.begin(), payload.end());
  const uint16_t sum = checksum(payload);
  packet.push_back(static_cast<uint8_t>(sum >> 8));
  packet.push_back(static_cast<uint8_t>(sum & 0xFF));
  return packet;
}

std::optional<Bytes> PacketParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    const bool begins = rest[0] == kHead1 && (rest.size() < 2 || rest[1] == kHead2) &&
                        (rest.size() < 3 || (rest[2] >= 3 && rest[2] <= kMaxPayload + 2));
    if (!begins) {
      unread_.skip();
      continue;
    }
    if (rest.size() < 3 || rest.size() < std::size_t{3} + rest[2]) return std::nullopt;
    const std::size_t length = rest[2] - std::size_t{2};
    const auto payload = rest.subspan(3, length);
    const unsigned sum = static_cast<unsigned>(rest[3 + length] << 8 | rest[4 + length]);
    if (sum != checksum(payload)) {
      ++bad_checksums_;
      unread_.skip();
      continue;
    }
    Bytes found(payload.begin(), payload.end());
    unread_.take(5 + length);
    return found;
  }
  return std::nullopt;
}

Bytes encode_command(const Command& command) {
  Bytes payload{static_cast<uint8_t>(command.id)};
  if (command.value) {
    require(std::abs(*command.value) <= 0xFFFF, "a command's value has sixteen bits and a sign");
    payload.push_back(*command.value >= 0 ? kPositiveArgument : kNegativeArgument);
    put_u16(payload, static_cast<unsigned>(std::abs(*command.value)));
  } else if (!command.text.empty()) {
    payload.push_back(kText);
    payload.push_back(static_cast<uint8_t>(command.text.size()));
    payload.insert(payload.end(), command.text.begin(), command.text.end());
  }
  return encode_packet(payload);
}

std::optional<Command> decode_command(std::span<const uint8_t> payload) {
  if (payload.empty()) return std::nullopt;
  Command command;
  command.id = static_cast<CommandId>(payload[0]);
  if (payload.size() == 1) return command;
  if ((payload[1] == kPositiveArgument || payload[1] == kNegativeArgument) && payload.size() >= 4) {
    const int size = get_u16(payload, 2);
    command.value = payload[1] == kPositiveArgument ? size : -size;
    return command;
  }
  if (payload[1] == kText && payload.size() >= 3 && payload.size() >= std::size_t{3} + payload[2]) {
    command.text.assign(payload.begin() + 3, payload.begin() + 3 + payload[2]);
    return command;
  }
  return std::nullopt;
}

Bytes encode_name(const RobotName& name) {
  FieldWriter out(kNamePacket);
  for (const std::string* text : {&name.name, &name.type, &name.subtype}) out.text(*text);
  return out.packet();
}

std::optional<RobotName> decode_name(std::span<const uint8_t> payload) {
  if (payload.empty() || payload[0] != kNamePacket) return std::nullopt;
  FieldReader in(payload);
  RobotName name;
  for (std::string* text : {&name.name, &name.type, &name.subtype}) in.text(*text);
  return in.good() ? std::optional(name) : std::nullopt;
}

Bytes encode_sip(const Sip& sip) {
  FieldWriter out(sip.moving ? kMoving : kStanding);
  sip_fields(out, sip);
  return out.packet();
}

std::optional<Sip> decode_sip(std::span<const uint8_t> payload) {
  if (payload.empty() || (payload[0] != kStanding && payload[0] != kMoving)) return std::nullopt;
  FieldReader in(payload);
  Sip sip;
  sip.moving = payload[0] == kMoving;
  sip_fields(in, sip);
  return in.good() ? std::optional(sip) : std::nullopt;
}

std::optional<Model> model_of(const std::string& subtype) {
  static constexpr Model kModels[] = {
      {"p2dx", 0.84, 0.268, 0.0056},  {"p2de", 0.969, 0.268, 0.0056}, {"p2d8", 0.485, 1.0, 0.0056},
      {"p2ce", 0.826, 0.268, 0.0056}, {"p2at", 1.32, 0.268, 0.0034},  {"p3dx", 0.485, 1.0, 0.0056},
      {"p3at", 0.465, 1.0, 0.0034},   {"p3dx-sh", 1.0, 1.0, 0.0056},  {"p3at-sh", 1.0, 1.0, 0.0034},
  };
  std::string lower = subtype;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto* found = std::find_if(std::begin(kModels), std::end(kModels),
                                   [&](const Model& model) { return lower == model.subtype; });
  return found == std::end(kModels) ? std::nullopt : std::optional(*found);
}

const std::array<Pose2, 16>& p2dx_sonars() {
  static const std::array<Pose2, 16> kSonars = [] {
    constexpr double kMillimetresAndDegrees[16][3] = {
        {69, 136, 90},     {114, 119, 50},     {148, 78, 30},     {166, 27, 10},
        {166, -27, -10},   {148, -78, -30},    {114, -119, -50},  {69, -136, -90},
        {-157, -136, -90}, {-203, -119, -130}, {-237, -78, -150}, {-255, -27, -170},
        {-255, 27, 170},   {-237, 78, 150},    {-203, 119, 130},  {-157, 136, 90}};
    std::array<Pose2, 16> sonars;
    for (std::size_t i = 0; i < 16; ++i) {
      sonars[i] = {kMillimetresAndDegrees[i][0] * 1e-3, kMillimetresAndDegrees[i][1] * 1e-3,
                   deg_to_rad(kMillimetresAndDegrees[i][2])};
    }
    return sonars;
  }();
  return kSonars;
}

}  // namespace marco::drivers::p2os
