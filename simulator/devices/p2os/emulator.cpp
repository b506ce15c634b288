#include "simulator/devices/p2os/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace marco::drivers::p2os {
namespace {

constexpr Duration kStep = Duration::from_us(5000);
constexpr std::size_t kSonarsPerCycle = 4;
constexpr int kHostBauds[] = {9600, 19'200, 38'400, 57'600, 115'200};

}  // namespace

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

P2osEmulator::P2osEmulator(P2osWorld world, const P2osEmulatorOptions& options)
    : world_(std::move(world)),
      options_(options),
      model_(model_of(options.name.subtype).value_or(*model_of("p2dx"))),
      drive_(options),
      requested_(world_, options_, drive_) {
  set_host_baud(options_.host_baud);
}

void P2osEmulator::reset() {
  const Utime last_packet = client_.last_packet;
  client_ = {};
  client_.last_packet = last_packet;
  drive_.reset();
  requested_.reset();
  set_host_baud(options_.host_baud);
  output_.clear();
  parser_.clear();
}

void P2osEmulator::on_connection(bool /*connected*/, Utime now) {
  run_until(now);
  output_.clear();
  parser_.clear();
}

void P2osEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  run_until(now);
  if (baud != 0 && baud != output_.baud()) return;  // noise at another speed
  parser_.push(bytes);
  while (const auto payload = parser_.next()) handle(*payload, now);
}

void P2osEmulator::handle(std::span<const uint8_t> payload, Utime now) {
  const auto command = decode_command(payload);
  if (!command) return;
  client_.last_packet = now;
  if (client_.sync < 3) return synchronize(payload, *command, now);
  if (command->id == CommandId::open) {
    client_.open = client_.sonars_on = true;  // SONAR 0 silences them
    next_sip_ = now + Duration::from_seconds(options_.cycle_s);
    return;
  }
  if (command->id == CommandId::close) return close();
  if (!client_.open) return;
  if (command->id == CommandId::host_baud) return set_host_baud(command->value.value_or(1));
  if (command->id == CommandId::sonar) client_.sonars_on = command->value.value_or(0) != 0;
  if (const auto packet = requested_.answer(*command, host_baud_code(), now)) {
    if (!packet->empty()) output_.send(*packet, now);
    return;
  }
  drive_.execute(*command);
}

void P2osEmulator::synchronize(std::span<const uint8_t> payload,
                               const Command& command,
                               Utime now) {
  if (static_cast<int>(command.id) != client_.sync || command.value) {
    output_.send(encode_packet(std::array<uint8_t, 1>{0xFF}), now);
    client_.sync = 0;
    return;
  }
  output_.send(client_.sync == 2 ? encode_name(options_.name) : encode_packet(payload), now);
  ++client_.sync;
}

void P2osEmulator::close() {
  client_.open = client_.sonars_on = false;
  client_.sync = 0;
  drive_.release();
  requested_.stop_repeating();
  set_host_baud(options_.host_baud);
}

void P2osEmulator::set_host_baud(int code) {
  if (code < 0 || code >= static_cast<int>(std::size(kHostBauds))) return;
  if (kHostBauds[code] != output_.baud()) baud_after_sending_ = kHostBauds[code];
}

int P2osEmulator::host_baud_code() const {
  const auto* found = std::find(std::begin(kHostBauds), std::end(kHostBauds), output_.baud());
  return static_cast<int>(found - kHostBauds);
}

void P2osEmulator::run_until(Utime now) {
  if (!now_) now_ = client_.last_packet = now;
  while (*now_ + kStep <= now) {
    now_ = *now_ + kStep;
    if ((*now_ - client_.last_packet).seconds() > options_.watchdog_s) drive_.brake();
    drive_.step(kStep.seconds(), world_.touched(options_.bumpers_each_end).stalled);
    requested_.head().advance(*now_);
    if (!client_.open || *now_ < next_sip_) continue;
    next_sip_ = next_sip_ + Duration::from_seconds(options_.cycle_s);
    output_.send(encode_sip(sip()), *now_);
    for (const Bytes& packet : requested_.repeated()) output_.send(packet, *now_);
  }
}

Sip P2osEmulator::sip() {
  Sip sip;
  const auto wrap = [](double raw) {
    return static_cast<uint16_t>(static_cast<int64_t>(std::lround(raw)) & 0x7FFF);
  };
  const double velocity = velocity_m_per_s(), rate = yaw_rate_rad_per_s();
  sip.moving = velocity != 0.0 || rate != 0.0;
  sip.x = wrap(reckoned().x_m * 1e3 / model_.mm_per_distance);
  sip.y = wrap(reckoned().y_m * 1e3 / model_.mm_per_distance);
  sip.heading = static_cast<int16_t>(std::lround(reckoned().theta_rad / kRadPerHeading));
  const double spread = rate * options_.track_m / 2.0;
  const double velocities = 1e3 / model_.mm_per_s_per_velocity;
  sip.left_speed = static_cast<int16_t>(std::lround((velocity - spread) * velocities));
  sip.right_speed = static_cast<int16_t>(std::lround((velocity + spread) * velocities));
  sip.battery = static_cast<uint8_t>(std::clamp(std::lround(world_.volts() * 10.0), 0L, 255L));
  const Touch touched = world_.touched(options_.bumpers_each_end);
  const int stall = drive_.stalled() ? 1 : 0;
  sip.left_stall = static_cast<uint8_t>(stall | touched.rear << 1);
  sip.right_stall = static_cast<uint8_t>(stall | touched.front << 1);
  sip.digital_out = requested_.digital_out();
  sip.flags = static_cast<uint16_t>((motors_on() ? 1 : 0) | (client_.sonars_on ? 0x1E : 0));
  if (client_.sonars_on) add_sonars(sip);
  return sip;
}

void P2osEmulator::add_sonars(Sip& sip) {
  constexpr double kNoEchoMm = 5000.0;
  for (std::size_t i = 0; i < kSonarsPerCycle; ++i) {
    const std::size_t number = next_sonar_++ % model_.robot_from_sonar.size();
    const auto& robot_from_sonar = model_.robot_from_sonar[number];
    const bool hears = robot_from_sonar && world_.sonar_range_m;
    const double mm = hears ? world_.sonar_range_m(*robot_from_sonar) * 1e3 : kNoEchoMm;
    sip.sonars.push_back(
        {static_cast<uint8_t>(number),
         static_cast<uint16_t>(std::lround(std::min(mm, kNoEchoMm) / model_.mm_per_range))});
  }
}

void P2osEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  run_until(now);
  output_.advance(now, out);
  if (baud_after_sending_ != 0 && output_.empty()) {
    output_.set_baud(std::exchange(baud_after_sending_, 0));
  }
}

Utime P2osEmulator::next_event() const {
  if (!now_) return Utime{};
  return std::min(*now_ + kStep, output_.next_event());
}

}  // namespace marco::drivers::p2os
