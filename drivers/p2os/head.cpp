// The driver's side of the camera head: VISCA through the robot's second serial port.
#include <algorithm>
#include <cmath>

#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/camera_head.hpp"
#include "drivers/p2os/driver.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr double kAskEveryS = 0.25;
constexpr int kAnswerBytes = 11;  // 90 50, four nibbles of pan, four of tilt, FF
constexpr double kTopPanDegPerS = 80.0, kTopTiltDegPerS = 50.0;

uint8_t speed_code(double rate_rad_per_s, double top_deg_per_s, int top) {
  if (rate_rad_per_s <= 0.0) return static_cast<uint8_t>(top);
  const double code = rad_to_deg(rate_rad_per_s) / top_deg_per_s * top;
  return static_cast<uint8_t>(std::clamp(std::lround(code), 1L, static_cast<long>(top)));
}

void put_nibbles(Bytes& message, int value) {
  for (int shift = 12; shift >= 0; shift -= 4) {
    message.push_back(static_cast<uint8_t>(value >> shift & 0x0F));
  }
}

int nibbles_at(const Bytes& payload, std::size_t at) {
  int value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 4 | (payload[at + i] & 0x0F);
  return static_cast<int16_t>(value);
}

}  // namespace

void P2osBase::say_to_head(const Bytes& message) {
  const Bytes packet =
      encode_command({kTty2, std::nullopt, std::string(message.begin(), message.end())});
  to_send_.insert(to_send_.end(), packet.begin(), packet.end());
}

void P2osBase::look(const PanTiltCommand& command, Utime now) {
  if (!options_.camera_head || sync_ < 3) return;
  const uint8_t pan_speed =
      speed_code(command.pan_rate_rad_per_s, kTopPanDegPerS, CameraHead::kTopPan);
  const uint8_t tilt_speed =
      speed_code(command.tilt_rate_rad_per_s, kTopTiltDegPerS, CameraHead::kTopTilt);
  if (command.kind == PanTiltCommand::Kind::stop) {
    say_to_head({0x81, 0x01, 0x06, 0x01, pan_speed, tilt_speed, 3, 3, 0xFF});
  } else {
    const auto units = [](double angle_rad, double per_deg, int most) {
      const double wanted = rad_to_deg(angle_rad) * per_deg;
      return static_cast<int>(std::lround(std::clamp<double>(wanted, -most, most)));
    };
    Bytes message{0x81, 0x01, 0x06, 0x02, pan_speed, tilt_speed};
    // The device counts to the right.
    put_nibbles(message,
                -units(command.pan_rad, CameraHead::kUnitsPerPanDeg, CameraHead::kMostPan));
    put_nibbles(message,
                units(command.tilt_rad, CameraHead::kUnitsPerTiltDeg, CameraHead::kMostTilt));
    message.push_back(0xFF);
    say_to_head(message);
  }
  next_head_ = now + Duration::from_seconds(kAskEveryS);
}

void P2osBase::ask_head(Utime now) {
  next_head_ = now + Duration::from_seconds(kAskEveryS);
  say(kGetAux, 0);  // away with what it said to the orders before
  say_to_head({0x81, 0x09, 0x06, 0x12, 0xFF});
  say(kGetAux, kAnswerBytes);
}

void P2osBase::on_head(const Bytes& payload, Utime arrival) {
  if (payload.size() != 1 + kAnswerBytes || payload[1] != 0x90 || payload[2] != 0x50) return;
  PanTiltState state;
  state.utime = arrival;  // the head's own line and the robot's cycle hide when it was asked
  state.pan_rad = -deg_to_rad(nibbles_at(payload, 3) / CameraHead::kUnitsPerPanDeg);
  state.tilt_rad = deg_to_rad(nibbles_at(payload, 7) / CameraHead::kUnitsPerTiltDeg);
  output().head.push_back(state);
}

}  // namespace marco::drivers::p2os
