#include "simulator/devices/p2os/camera_head.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr std::size_t kLongest = 16;
constexpr int kTopZoom = 1023;

}  // namespace

double CameraHead::pan_rad() const { return -deg_to_rad(pan_ / kUnitsPerPanDeg); }
double CameraHead::tilt_rad() const { return deg_to_rad(tilt_ / kUnitsPerTiltDeg); }

void CameraHead::say(std::initializer_list<int> bytes) {
  for (const int byte : bytes) answers_.push_back(static_cast<uint8_t>(byte));
}

void CameraHead::say_words(std::initializer_list<int> words) {
  say({0x90, 0x50});
  for (const int word : words) put_visca_word(answers_, word);
  answers_.push_back(kViscaEnd);
}

void CameraHead::receive(std::span<const uint8_t> bytes, Utime now) {
  advance(now);
  for (const uint8_t byte : bytes) {
    if (byte >= 0x80 && byte != 0xFF) message_.clear();  // only a beginning has this bit
    if (message_.empty() && (byte < 0x80 || byte == 0xFF)) continue;
    message_.push_back(byte);
    if (byte == 0xFF) {
      if (message_[0] == 0x81 || message_[0] == 0x88) handle(message_);
      message_.clear();
    } else if (message_.size() >= kLongest) {
      message_.clear();
    }
  }
}

void CameraHead::handle(std::span<const uint8_t> message) {
  const auto is = [message](std::initializer_list<int> code, std::size_t size) {
    return message.size() == size &&
           std::equal(code.begin(), code.end(), message.begin() + 1,
                      [](int wanted, uint8_t byte) { return wanted == byte; });
  };
  if (is({0x30}, 4)) return say({0x88, 0x30, 0x02, 0xFF});                    // address
  if (is({0x01, 0x00, 0x01}, 5)) return say({0x88, 0x01, 0x00, 0x01, 0xFF});  // clear
  if (is({0x09, 0x06, 0x12}, 5)) {
    return say_words({static_cast<int>(std::lround(pan_)), static_cast<int>(std::lround(tilt_))});
  }
  if (is({0x09, 0x04, 0x47}, 5)) return say_words({zoom_});
  if (is({0x09, 0x04, 0x00}, 5)) return say({0x90, 0x50, on_ ? 2 : 3, 0xFF});
  if (is({0x01, 0x04, 0x00}, 6)) {
    on_ = message[4] == 2;
    return done();
  }
  if (is({0x01, 0x04, 0x47}, 9)) {
    zoom_ = std::clamp(visca_word(message, 4), 0, kTopZoom);
    return done();
  }
  if (message.size() >= 5 && message[1] == 0x01 && message[2] == 0x06) return pan_tilt(message);
  say({0x90, 0x60, 0x02, 0xFF});  // not understood
}

void CameraHead::done() { say({0x90, 0x41, 0xFF, 0x90, 0x51, 0xFF}); }

void CameraHead::pan_tilt(std::span<const uint8_t> message) {
  const uint8_t kind = message[3];
  const bool home = (kind == 0x04 || kind == 0x05) && message.size() == 5;
  const bool move = (kind == 0x02 || kind == 0x03) && message.size() == 15;
  const bool drive = kind == 0x01 && message.size() == 9;
  if (!on_ || (!home && !move && !drive)) return say({0x90, 0x61, on_ ? 0x02 : 0x41, 0xFF});
  int pan = 0, tilt = 0;
  int pan_speed = kTopPan, tilt_speed = kTopTilt;
  if (!home) {
    pan_speed = std::clamp<int>(message[4], 1, kTopPan);
    tilt_speed = std::clamp<int>(message[5], 1, kTopTilt);
  }
  if (move) {
    const bool relative = kind == 0x03;
    pan = visca_word(message, 6) + (relative ? static_cast<int>(std::lround(pan_)) : 0);
    tilt = visca_word(message, 10) + (relative ? static_cast<int>(std::lround(tilt_)) : 0);
  } else if (drive) {
    // 1 left or up, 2 right or down, 3 stop: until the end of its way.
    const auto way = [](uint8_t code, double now, int most) {
      return code == 1 ? -most : code == 2 ? most : static_cast<int>(std::lround(now));
    };
    pan = way(message[6], pan_, kMostPan);
    tilt = -way(message[7], -tilt_, kMostTilt);
  }
  pan_goal_ = std::clamp(pan, -kMostPan, kMostPan);
  tilt_goal_ = std::clamp(tilt, -kMostTilt, kMostTilt);
  pan_rate_ = kTopPanDegPerS * kUnitsPerPanDeg * pan_speed / kTopPan;
  tilt_rate_ = kTopTiltDegPerS * kUnitsPerTiltDeg * tilt_speed / kTopTilt;
  say({0x90, 0x41, 0xFF});
  tell_arrival_ = true;
}

void CameraHead::advance(Utime now) {
  const double passed_s = now_.us == 0 ? 0.0 : (now - now_).seconds();
  now_ = now;
  pan_ = approach(pan_, pan_goal_, pan_rate_ * passed_s);
  tilt_ = approach(tilt_, tilt_goal_, tilt_rate_ * passed_s);
  if (tell_arrival_ && !moving()) {
    tell_arrival_ = false;
    say({0x90, 0x51, 0xFF});
  }
}

}  // namespace marco::drivers::p2os
