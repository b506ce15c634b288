#include "drivers/p2os/head_client.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/p2os/visca.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr double kAskEveryS = 0.25;
constexpr int kAnswerBytes = 11;  // 90 50, four nibbles of pan, four of tilt, FF

uint8_t speed_code(double rate_rad_per_s, double top_deg_per_s, int top) {
  if (rate_rad_per_s <= 0.0) return static_cast<uint8_t>(top);
  const double code = rad_to_deg(rate_rad_per_s) / top_deg_per_s * top;
  return static_cast<uint8_t>(std::clamp(std::lround(code), 1L, static_cast<long>(top)));
}

int units(double angle_rad, double per_deg, int most) {
  const double wanted = rad_to_deg(angle_rad) * per_deg;
  return static_cast<int>(std::lround(std::clamp<double>(wanted, -most, most)));
}

Bytes to_head(const Bytes& message) {
  return encode_command(
      {CommandId::tty2, std::nullopt, std::string(message.begin(), message.end())});
}

}  // namespace

Bytes HeadClient::power_on(Utime now) {
  next_ask_ = now;
  return to_head({0x81, 0x01, 0x04, 0x00, 0x02, kViscaEnd});
}

Bytes HeadClient::look(const PanTiltCommand& command, Utime now) {
  next_ask_ = now + Duration::from_seconds(kAskEveryS);
  const uint8_t pan_speed = speed_code(command.pan_rate_rad_per_s, kTopPanDegPerS, kTopPan);
  const uint8_t tilt_speed = speed_code(command.tilt_rate_rad_per_s, kTopTiltDegPerS, kTopTilt);
  if (command.kind == PanTiltCommand::Kind::stop) {
    return to_head({0x81, 0x01, 0x06, 0x01, pan_speed, tilt_speed, 3, 3, kViscaEnd});
  }
  Bytes message{0x81, 0x01, 0x06, 0x02, pan_speed, tilt_speed};
  put_visca_word(message, -units(command.pan_rad, kUnitsPerPanDeg, kMostPan));
  put_visca_word(message, units(command.tilt_rad, kUnitsPerTiltDeg, kMostTilt));
  message.push_back(kViscaEnd);
  return to_head(message);
}

Bytes HeadClient::ask(Utime now) {
  if (now < next_ask_) return {};
  next_ask_ = now + Duration::from_seconds(kAskEveryS);
  Bytes packets =
      encode_command({CommandId::get_aux, 0, ""});  // drops its answers to the orders before
  for (const Bytes& packet : {to_head({0x81, 0x09, 0x06, 0x12, kViscaEnd}),
                              encode_command({CommandId::get_aux, kAnswerBytes, ""})}) {
    packets.insert(packets.end(), packet.begin(), packet.end());
  }
  return packets;
}

std::optional<PanTiltState> HeadClient::decode(std::span<const uint8_t> payload, Utime arrival) {
  if (payload.size() != 1 + kAnswerBytes || payload[1] != 0x90 || payload[2] != 0x50) {
    return std::nullopt;
  }
  PanTiltState state;
  state.utime = arrival;  // the head's own line and the robot's cycle hide when it was asked
  state.pan_rad = -deg_to_rad(visca_word(payload, 3) / kUnitsPerPanDeg);
  state.tilt_rad = deg_to_rad(visca_word(payload, 7) / kUnitsPerTiltDeg);
  return state;
}

}  // namespace marco::drivers::p2os
