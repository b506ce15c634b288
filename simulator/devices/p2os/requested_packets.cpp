#include "simulator/devices/p2os/requested_packets.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::p2os {

Touch P2osWorld::touched(int bumpers_each_end) const {
  Touch touched = touch ? touch() : Touch{};
  if (bumpers_each_end == 0) touched.front = touched.rear = 0x7F;
  return touched;
}

void RequestedPackets::reset() {
  stop_repeating();
  digital_out_ = 0;
  aux_wanted_ = 0;
}

std::optional<Bytes> RequestedPackets::answer(const Command& command,
                                              int host_baud_code,
                                              Utime now) {
  constexpr std::size_t kMostAux = 190;
  const int value = command.value.value_or(1);
  switch (command.id) {
    case CommandId::config:
      return options_.tells_config ? encode_config(config(host_baud_code)) : Bytes{};
    case CommandId::encoder:
      encoders_asked_ = value > 1;
      return value == 1 ? encode_encoders(encoders()) : Bytes{};
    case CommandId::io_request:
      ports_asked_ = value > 1;
      return value == 1 ? encode_io(ports()) : Bytes{};
    case CommandId::gripper_request:
      // Kind 0: none is fitted; no state, no time.
      return value != 0 ? encode_packet(Bytes{kGripperPacket, 0, 0, 0}) : Bytes{};
    case CommandId::digital_out: {
      const auto states = static_cast<uint8_t>(value), mask = static_cast<uint8_t>(value >> 8);
      digital_out_ = static_cast<uint8_t>((digital_out_ & ~mask) | (states & mask));
      return Bytes{};
    }
    case CommandId::tty2:
      head_.receive(Bytes(command.text.begin(), command.text.end()), now);
      return Bytes{};
    case CommandId::get_aux:
      if (value == 0) head_.answers().clear();  // empties the port's buffer
      aux_wanted_ = std::min(static_cast<std::size_t>(std::max(0, value)), kMostAux);
      return Bytes{};
    default:
      return std::nullopt;
  }
}

std::vector<Bytes> RequestedPackets::repeated() {
  std::vector<Bytes> packets;
  if (encoders_asked_) packets.push_back(encode_encoders(encoders()));
  if (ports_asked_) packets.push_back(encode_io(ports()));
  Bytes& waiting = head_.answers();
  if (aux_wanted_ > 0 && waiting.size() >= aux_wanted_) {
    const auto end = waiting.begin() + static_cast<std::ptrdiff_t>(aux_wanted_);
    packets.push_back(encode_aux(Bytes(waiting.begin(), end)));
    waiting.erase(waiting.begin(), end);
    aux_wanted_ = 0;
  }
  return packets;
}

RobotConfig RequestedPackets::config(int host_baud_code) const {
  const auto whole = [](double value) { return static_cast<int>(std::lround(value)); };
  const SpeedProfile& velocity = drive_.velocity();
  const SpeedProfile& rate = drive_.rate();
  RobotConfig config;
  config.name = options_.name;
  config.serial_number = options_.name.name + "-0001";
  config.velocity_top = whole(options_.max_velocity_m_per_s * 1e3);
  config.cycle_ms = whole(options_.cycle_s * 1e3);
  config.host_baud = host_baud_code;
  config.watchdog_ms = whole(options_.watchdog_s * 1e3);
  config.velocity_max = whole(velocity.limit * 1e3);
  config.rotation_max = whole(rad_to_deg(rate.limit));
  config.acceleration = whole(velocity.acceleration * 1e3);
  config.deceleration = whole(velocity.deceleration * 1e3);
  config.rotation_acceleration = whole(rad_to_deg(rate.acceleration));
  config.rotation_deceleration = whole(rad_to_deg(rate.deceleration));
  config.front_bumpers = config.rear_bumpers = options_.bumpers_each_end;
  config.ticks_per_mm = options_.ticks_per_mm;
  return config;
}

Encoders RequestedPackets::encoders() const {
  const auto ticks = [this](double way_m) {
    return static_cast<int32_t>(std::llround(way_m * 1e3 * options_.ticks_per_mm));
  };
  return {ticks(drive_.left_m()), ticks(drive_.right_m())};
}

IoPorts RequestedPackets::ports() const {
  const Touch touched = world_.touched(options_.bumpers_each_end);
  // Bumpers pull their line down; the ninth analog line is the battery's, of which a bit is 20 mV.
  return {{static_cast<uint8_t>(~touched.front), static_cast<uint8_t>(~touched.rear), 0xFF},
          {digital_out_},
          {0, 0, 0, 0, 0, 0, 0, 0, static_cast<uint16_t>(std::lround(world_.volts() * 50.0))}};
}

}  // namespace marco::drivers::p2os
