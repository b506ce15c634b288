// The emulator's second half: what the robot tells only when it is asked.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/p2os/emulator.hpp"

namespace marco::drivers::p2os {
namespace {

constexpr int kHostBauds[] = {9600, 19'200, 38'400, 57'600, 115'200};
constexpr std::size_t kMostAux = 190;

}  // namespace

bool P2osEmulator::answer(const Command& command, Utime now) {
  const int value = command.value.value_or(1);
  switch (command.id) {
    case kConfig:
      if (options_.tells_config) send(encode_config(config()), now);
      return true;
    case kEncoder:
      if (value == 1) send(encode_encoders(encoders()), now);
      encoders_asked_ = value > 1;
      return true;
    case kIoRequest:
      if (value == 1) send(encode_io(ports()), now);
      ports_asked_ = value > 1;
      return true;
    case kGripperRequest:
      // Kind 0: none is fitted; no state, no time.
      if (value != 0) send(encode_packet(Bytes{kGripperPacket, 0, 0, 0}), now);
      return true;
    case kDigOut: {
      const auto states = static_cast<uint8_t>(value), mask = static_cast<uint8_t>(value >> 8);
      digital_out_ = static_cast<uint8_t>((digital_out_ & ~mask) | (states & mask));
      return true;
    }
    case kHostBaud:
      set_host_baud(value);
      return true;
    case kTty2:
      head_.receive(Bytes(command.text.begin(), command.text.end()), now);
      return true;
    case kGetAux:
      // 0 empties the port's buffer.
      if (value == 0) head_.answers().clear();
      aux_wanted_ = std::min(static_cast<std::size_t>(std::max(0, value)), kMostAux);
      return true;
    default:
      return false;
  }
}

void P2osEmulator::set_host_baud(int code) {
  if (code < 0 || code >= static_cast<int>(std::size(kHostBauds))) return;
  if (kHostBauds[code] != baud_) baud_after_sending_ = kHostBauds[code];
}

void P2osEmulator::send_asked(Utime now) {
  if (encoders_asked_) send(encode_encoders(encoders()), now);
  if (ports_asked_) send(encode_io(ports()), now);
  Bytes& waiting = head_.answers();
  if (aux_wanted_ > 0 && waiting.size() >= aux_wanted_) {
    const auto end = waiting.begin() + static_cast<std::ptrdiff_t>(aux_wanted_);
    send(encode_aux(Bytes(waiting.begin(), end)), now);
    waiting.erase(waiting.begin(), end);
    aux_wanted_ = 0;
  }
}

RobotConfig P2osEmulator::config() const {
  const auto whole = [](double value) { return static_cast<int>(std::lround(value)); };
  RobotConfig config;
  config.name = options_.name;
  config.serial_number = options_.name.name + "-0001";
  config.velocity_top = whole(options_.max_velocity_m_per_s * 1e3);
  config.cycle_ms = whole(options_.cycle_s * 1e3);
  config.host_baud =
      static_cast<int>(std::find(std::begin(kHostBauds), std::end(kHostBauds), baud_) - kHostBauds);
  config.watchdog_ms = whole(options_.watchdog_s * 1e3);
  config.velocity_max = whole(max_velocity_ * 1e3);
  config.rotation_max = whole(rad_to_deg(max_rate_));
  config.acceleration = whole(acceleration_ * 1e3);
  config.deceleration = whole(deceleration_ * 1e3);
  config.rotation_acceleration = whole(rad_to_deg(rate_acceleration_));
  config.rotation_deceleration = whole(rad_to_deg(rate_deceleration_));
  config.front_bumpers = config.rear_bumpers = options_.bumpers_each_end;
  config.ticks_per_mm = options_.ticks_per_mm;
  return config;
}

Encoders P2osEmulator::encoders() const {
  const auto ticks = [this](double way_m) {
    return static_cast<int32_t>(std::llround(way_m * 1e3 * options_.ticks_per_mm));
  };
  return {ticks(left_m_), ticks(right_m_)};
}

IoPorts P2osEmulator::ports() const {
  const Touch touch = this->touch();
  const auto volts = world_.battery_v ? world_.battery_v() : 12.6;
  // Bumpers pull their line down; the ninth analog line is the battery's, of which a bit is 20 mV.
  return {{static_cast<uint8_t>(~touch.front), static_cast<uint8_t>(~touch.rear), 0xFF},
          {digital_out_},
          {0, 0, 0, 0, 0, 0, 0, 0, static_cast<uint16_t>(std::lround(volts * 50.0))}};
}

}  // namespace marco::drivers::p2os
