#include "drivers/p2os/codec.hpp"

#include <algorithm>
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

}  // namespace marco::drivers::p2os
