#include "drivers/create/codec.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::create {
namespace {

constexpr uint8_t kStreamHeader = 0x13;
constexpr std::size_t kMostPayload = 172;
constexpr std::array<uint8_t, 10> kPackets{0x07, 0x09, 0x0A, 0x0B, 0x0C,
                                           0x15, 0x16, 0x23, 0x2B, 0x2C};

/// Bytes of the data of packets 7 to 58; 0 = not known.
std::size_t size_of(uint8_t packet) {
  constexpr uint8_t kFirst = 0x07;
  constexpr std::array<uint8_t, 52> kSizes{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 1, 2, 2, 1,
                                           2, 2, 2, 2, 2, 2, 2, 1, 2, 1, 1, 1, 1, 1, 2, 2, 2, 2,
                                           2, 2, 1, 2, 2, 2, 2, 2, 2, 1, 1, 2, 2, 2, 2, 1};
  return packet < kFirst || packet >= kFirst + kSizes.size() ? 0 : kSizes[packet - kFirst];
}

/// The packets that a question for `packet` is about: of a group several.
std::pair<uint8_t, uint8_t> first_and_last(uint8_t packet) {
  struct Group {
    uint8_t id, first, last;
  };
  constexpr std::array<Group, 11> kGroups{{{0, 7, 26},
                                           {1, 7, 16},
                                           {2, 17, 20},
                                           {3, 21, 26},
                                           {4, 27, 34},
                                           {5, 35, 42},
                                           {6, 7, 42},
                                           {100, 7, 58},
                                           {101, 43, 58},
                                           {106, 46, 51},
                                           {107, 54, 58}}};
  for (const Group& group : kGroups) {
    if (group.id == packet) return {group.first, group.last};
  }
  return {packet, packet};
}

int u16(std::span<const uint8_t> data) { return data[0] << 8 | data[1]; }

void put_u16(Bytes& bytes, int value) {
  bytes.push_back(static_cast<uint8_t>(value >> 8));
  bytes.push_back(static_cast<uint8_t>(value));
}

uint8_t sum_of(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum = static_cast<uint8_t>(sum + byte);
  return sum;
}

void read_packet(uint8_t packet, std::span<const uint8_t> data, Sensors& sensors) {
  switch (packet) {
    case 0x07:
      sensors.right_bump = (data[0] & 1) != 0;
      sensors.left_bump = (data[0] & 2) != 0;
      sensors.right_drop = (data[0] & 4) != 0;
      sensors.left_drop = (data[0] & 8) != 0;
      break;
    case 0x09:
    case 0x0A:
    case 0x0B:
    case 0x0C:
      sensors.cliffs[packet - 0x09U] = (data[0] & 1) != 0;
      break;
    case 0x15:
      sensors.charging = data[0];
      break;
    case 0x16:
      sensors.millivolts = u16(data);
      break;
    case 0x23:
      sensors.mode = data[0];
      break;
    case 0x2B:
      sensors.left_ticks = static_cast<uint16_t>(u16(data));
      break;
    case 0x2C:
      sensors.right_ticks = static_cast<uint16_t>(u16(data));
      break;
    default:
      break;
  }
}

int value_of(uint8_t packet, const Sensors& sensors) {
  const auto bit = [](bool value, int place) { return value ? 1 << place : 0; };
  switch (packet) {
    case 0x07:
      return bit(sensors.right_bump, 0) | bit(sensors.left_bump, 1) | bit(sensors.right_drop, 2) |
             bit(sensors.left_drop, 3);
    case 0x09:
    case 0x0A:
    case 0x0B:
    case 0x0C:
      return sensors.cliffs[packet - 0x09U] ? 1 : 0;
    case 0x15:
      return sensors.charging;
    case 0x16:
      return sensors.millivolts;
    case 0x23:
      return sensors.mode;
    case 0x2B:
      return sensors.left_ticks;
    case 0x2C:
      return sensors.right_ticks;
    default:
      return 0;
  }
}

/// Of requests that a host may send besides ours; the rest have no data.
std::optional<std::size_t> data_size(std::span<const uint8_t> request) {
  switch (request[0]) {
    case 0x81:  // baud
    case 0x8A:  // brushes
    case 0x8D:  // play
    case 0x8E:  // one sensor packet
    case 0x96:
    case 0xA5:  // buttons
      return 1;
    case 0xA2:  // lights of the schedule
      return 2;
    case 0x8B:  // lights
    case 0x90:  // brushes by PWM
    case 0xA8:  // day and time
      return 3;
    case 0x89:  // drive
    case 0x91:
    case 0x92:  // drive by PWM
    case 0xA3:  // digits
    case 0xA4:
      return 4;
    case 0xA7:  // schedule
      return 15;
    case 0x8C:  // song
      if (request.size() < 3) return std::nullopt;
      return 2U + 2U * request[2];
    case 0x94:
    case 0x95:  // query list
      if (request.size() < 2) return std::nullopt;
      return 1U + request[1];
    default:
      return 0;
  }
}

}  // namespace

Bytes encode_request(Opcode opcode) { return {static_cast<uint8_t>(opcode)}; }

Bytes stream_request() {
  Bytes request{static_cast<uint8_t>(Opcode::stream), kPackets.size()};
  std::copy(kPackets.begin(), kPackets.end(), std::back_inserter(request));
  return request;
}

Bytes drive_request(int left_mm_per_s, int right_mm_per_s) {
  require(std::abs(left_mm_per_s) <= kMostMmPerS && std::abs(right_mm_per_s) <= kMostMmPerS,
          "a Create's wheels turn with 500 mm/s at most");
  Bytes request{static_cast<uint8_t>(Opcode::drive_wheels)};
  put_u16(request, right_mm_per_s);
  put_u16(request, left_mm_per_s);
  return request;
}

Bytes encode_packets(const Sensors& sensors, std::span<const uint8_t> packets) {
  Bytes data;
  for (const uint8_t asked : packets) {
    const auto [first, last] = first_and_last(asked);
    for (uint8_t packet = first; packet <= last; ++packet) {
      if (size_of(packet) == 1) data.push_back(static_cast<uint8_t>(value_of(packet, sensors)));
      if (size_of(packet) == 2) put_u16(data, value_of(packet, sensors));
    }
  }
  return data;
}

Bytes encode_frame(const Sensors& sensors, std::span<const uint8_t> packets) {
  Bytes frame{kStreamHeader, 0};
  for (const uint8_t packet : packets) {
    const Bytes data = encode_packets(sensors, {&packet, 1});
    if (data.empty() || frame.size() + 1 + data.size() > 2 + kMostPayload) continue;
    frame.push_back(packet);
    std::copy(data.begin(), data.end(), std::back_inserter(frame));
  }
  frame[1] = static_cast<uint8_t>(frame.size() - 2);
  frame.push_back(static_cast<uint8_t>(-sum_of(frame)));
  return frame;
}

Bytes encode_frame(const Sensors& sensors) { return encode_frame(sensors, kPackets); }

std::optional<Sensors> decode_frame(std::span<const uint8_t> frame) {
  if (frame.size() < 3 || frame[0] != kStreamHeader || frame.size() != 3U + frame[1]) {
    return std::nullopt;
  }
  if (sum_of(frame) != 0) return std::nullopt;
  Sensors sensors;
  std::vector<uint8_t> seen;
  std::span<const uint8_t> rest = frame.subspan(2, frame[1]);
  while (!rest.empty()) {
    const std::size_t size = size_of(rest[0]);
    if (size == 0 || rest.size() <= size) return std::nullopt;
    read_packet(rest[0], rest.subspan(1, size), sensors);
    seen.push_back(rest[0]);
    rest = rest.subspan(1 + size);
  }
  const bool whole = std::all_of(kPackets.begin(), kPackets.end(), [&seen](uint8_t packet) {
    return std::find(seen.begin(), seen.end(), packet) != seen.end();
  });
  return whole ? std::optional(sensors) : std::nullopt;
}

std::optional<FrameParser::Received> FrameParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    if (rest[0] == kStreamHeader) {
      if (rest.size() < 2) return std::nullopt;
      const std::size_t size = 3U + rest[1];
      if (rest[1] <= kMostPayload && rest.size() < size) return std::nullopt;
      const auto sensors = rest[1] <= kMostPayload ? decode_frame(rest.first(size)) : std::nullopt;
      if (sensors) {
        unread_.take(size);
        return Received{*sensors, unread_.size()};
      }
    }
    unread_.skip();
  }
  return std::nullopt;
}

std::optional<Request> RequestParser::next() {
  if (unread_.empty()) return std::nullopt;
  const std::span<const uint8_t> rest = unread_.rest();
  const auto size = data_size(rest);
  if (!size || rest.size() < 1 + *size) return std::nullopt;
  const auto data = rest.subspan(1, *size);
  Request request{static_cast<Opcode>(rest[0]), Bytes(data.begin(), data.end())};
  unread_.take(1 + *size);
  return request;
}

}  // namespace marco::drivers::create
