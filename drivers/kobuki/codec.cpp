#include "drivers/kobuki/codec.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "drivers/transport/little_endian.hpp"

namespace marco::drivers::kobuki {
namespace {

constexpr uint8_t kHead[] = {0xAA, 0x55};
constexpr std::size_t kAround = 4;  // head, length, sum
constexpr double kHalfTrackM = kTrackM / 2.0;
constexpr uint8_t kMostReadings = 4;  // of the gyro in a frame

enum Part : uint8_t {
  kBasic = 0x01,
  kInertia = 0x04,
  kFirmware = 0x0B,
  kGyro = 0x0D,
};
enum OrderPart : uint8_t {
  kVelocity = 0x01,
  kAsk = 0x09,
};
constexpr uint8_t kAskHardware = 1, kAskFirmware = 2, kAskId = 8;

uint8_t xor_of(std::span<const uint8_t> bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), uint8_t{0}, [](uint8_t sum, uint8_t byte) {
    return static_cast<uint8_t>(sum ^ byte);
  });
}

void put_part(Bytes& payload, uint8_t id, const Bytes& data) {
  payload.push_back(id);
  payload.push_back(static_cast<uint8_t>(data.size()));
  payload.insert(payload.end(), data.begin(), data.end());
}

Bytes frame_of(const Bytes& payload) {
  Bytes frame{kHead[0], kHead[1], static_cast<uint8_t>(payload.size())};
  frame.insert(frame.end(), payload.begin(), payload.end());
  frame.push_back(xor_of(std::span<const uint8_t>(frame).subspan(2)));
  return frame;
}

int whole_mm(double metres) {
  return static_cast<int>(std::lround(std::clamp(1e3 * metres, -32'767.0, 32'767.0)));
}

/// Calls `use(id, data)` for each part. @returns false when one is cut off or `use` says so.
template <class Use>
bool for_each_part(std::span<const uint8_t> payload, const Use& use) {
  while (!payload.empty()) {
    if (payload.size() < 2 || payload.size() < 2U + payload[1]) return false;
    if (!use(payload[0], payload.subspan(2, payload[1]))) return false;
    payload = payload.subspan(2U + payload[1]);
  }
  return true;
}

bool read_basic(std::span<const uint8_t> data, Feedback& feedback) {
  if (data.size() != 15) return false;
  feedback.clock_ms = get_u16(data, 0);
  feedback.bumpers = data[2];
  feedback.hanging_wheels = data[3];
  feedback.cliffs = data[4];
  feedback.left_ticks = get_u16(data, 5);
  feedback.right_ticks = get_u16(data, 7);
  feedback.charger = data[12];
  feedback.decivolts = data[13];
  return true;
}

// A frame number, how many numbers follow, and three numbers for each reading.
bool read_gyro(std::span<const uint8_t> data, Feedback& feedback) {
  if (data.size() < 2 || data[1] % 3 != 0 || data[1] > 3 * kMostReadings ||
      data.size() != 2U + 2U * data[1]) {
    return false;
  }
  feedback.gyro.clear();
  for (std::size_t at = 2; at < data.size(); at += 6) {
    feedback.gyro.push_back({get_s16(data, at), get_s16(data, at + 2), get_s16(data, at + 4)});
  }
  return true;
}

bool read_part(uint8_t id, std::span<const uint8_t> data, Feedback& feedback) {
  switch (id) {
    case kBasic:
      return read_basic(data, feedback);
    case kInertia:
      if (data.size() != 7) return false;
      feedback.heading_cdeg = get_s16(data, 0);
      feedback.rate_cdeg_per_s = get_s16(data, 2);
      return true;
    case kGyro:
      return read_gyro(data, feedback);
    case kFirmware:
      if (data.size() < 3) return false;
      feedback.firmware = {data[2], data[1], data[0]};
      return true;
    default:
      return true;
  }
}

}  // namespace

Bytes velocity_request(double velocity_m_per_s, double yaw_rate_rad_per_s) {
  int speed_mm_per_s = whole_mm(velocity_m_per_s), radius_mm = 0;
  if (yaw_rate_rad_per_s != 0.0) {
    const double radius_m = velocity_m_per_s / yaw_rate_rad_per_s;
    const int radius = whole_mm(radius_m);
    if (std::abs(radius) <= 1) {
      radius_mm = 1;  // on the spot
      speed_mm_per_s = whole_mm(kHalfTrackM * yaw_rate_rad_per_s);
    } else if (std::abs(radius_m) < 32.0) {  // else straight
      radius_mm = radius;
      speed_mm_per_s =
          whole_mm((1e-3 * radius + std::copysign(kHalfTrackM, radius_m)) * yaw_rate_rad_per_s);
    }
  }
  Bytes data;
  put_u16(data, static_cast<unsigned>(speed_mm_per_s));
  put_u16(data, static_cast<unsigned>(radius_mm));
  Bytes payload;
  put_part(payload, kVelocity, data);
  return frame_of(payload);
}

Bytes version_request() {
  Bytes payload;
  put_part(payload, kAsk, {kAskHardware | kAskFirmware | kAskId, 0});
  return frame_of(payload);
}

Bytes encode_frame(const Feedback& feedback) {
  Bytes basic;
  put_u16(basic, feedback.clock_ms);
  basic.push_back(feedback.bumpers);
  basic.push_back(feedback.hanging_wheels);
  basic.push_back(feedback.cliffs);
  put_u16(basic, feedback.left_ticks);
  put_u16(basic, feedback.right_ticks);
  put_u16(basic, 0);   // motors' duty
  basic.push_back(0);  // buttons
  basic.push_back(feedback.charger);
  basic.push_back(feedback.decivolts);
  basic.push_back(0);  // currents
  Bytes inertia;
  put_u16(inertia, static_cast<unsigned>(feedback.heading_cdeg));
  put_u16(inertia, static_cast<unsigned>(feedback.rate_cdeg_per_s));
  inertia.resize(7);
  Bytes payload;
  put_part(payload, kBasic, basic);
  put_part(payload, kInertia, inertia);
  if (!feedback.gyro.empty()) {
    Bytes gyro{0, static_cast<uint8_t>(3 * feedback.gyro.size())};
    for (const auto& reading : feedback.gyro) {
      for (const int16_t value : reading) put_u16(gyro, static_cast<unsigned>(value));
    }
    put_part(payload, kGyro, gyro);
  }
  if (feedback.firmware) {
    const auto& [major, minor, patch] = *feedback.firmware;
    put_part(payload, kFirmware, {patch, minor, major, 0});
  }
  return frame_of(payload);
}

std::optional<Feedback> decode_feedback(std::span<const uint8_t> payload) {
  Feedback feedback;
  bool basic = false;
  const bool whole = for_each_part(payload, [&](uint8_t id, std::span<const uint8_t> data) {
    basic = basic || id == kBasic;
    return read_part(id, data, feedback);
  });
  return whole && basic ? std::optional(feedback) : std::nullopt;
}

std::optional<Order> decode_order(std::span<const uint8_t> payload) {
  Order order;
  const bool whole = for_each_part(payload, [&](uint8_t id, std::span<const uint8_t> data) {
    if (id == kAsk && data.size() == 2) order.asks_versions = true;
    if (id != kVelocity || data.size() != 4) return true;
    const double speed = 1e-3 * get_s16(data, 0), radius = 1e-3 * get_s16(data, 2);
    if (get_s16(data, 2) == 0) {
      order.velocity_m_per_s = speed;
      order.yaw_rate_rad_per_s = 0.0;
    } else if (get_s16(data, 2) == 1) {
      order.velocity_m_per_s = 0.0;
      order.yaw_rate_rad_per_s = speed / kHalfTrackM;
    } else {
      order.yaw_rate_rad_per_s = speed / (radius + std::copysign(kHalfTrackM, radius));
      order.velocity_m_per_s = radius * order.yaw_rate_rad_per_s;
    }
    return true;
  });
  return whole ? std::optional(order) : std::nullopt;
}

std::optional<FrameParser::Received> FrameParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    const bool may_begin = rest[0] == kHead[0] && (rest.size() < 2 || rest[1] == kHead[1]) &&
                           (rest.size() < 3 || rest[2] > 0);
    if (may_begin) {
      if (rest.size() < 3 || rest.size() < kAround + rest[2]) return std::nullopt;
      const std::size_t size = kAround + rest[2];
      if (xor_of(rest.subspan(2, size - 2)) == 0) {
        const auto payload = rest.subspan(3, rest[2]);
        unread_.take(size);
        return Received{{payload.begin(), payload.end()}, unread_.size()};
      }
    }
    unread_.skip();
  }
  return std::nullopt;
}

}  // namespace marco::drivers::kobuki
