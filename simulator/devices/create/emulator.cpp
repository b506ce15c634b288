#include "simulator/devices/create/emulator.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::create {
namespace {

constexpr Duration kStep = Duration::from_us(5000);
constexpr Duration kFrameEvery = Duration::from_us(15'000);
constexpr double kTickM = std::numbers::pi * kWheelDiameterM / kTicksPerTurn;

int s16(std::span<const uint8_t> data, std::size_t at) {
  return static_cast<int16_t>(static_cast<uint16_t>(data[at] << 8 | data[at + 1]));
}

/// Speeds of the wheels, left and right, that a host orders.
std::pair<double, double> wheels_of(const Request& request) {
  const int first = s16(request.data, 0), second = s16(request.data, 2);
  if (request.opcode == Opcode::drive_wheels) return {1e-3 * second, 1e-3 * first};
  if (request.opcode == Opcode::drive_pwm) return {second * 0.5 / 255.0, first * 0.5 / 255.0};
  // By the speed of the middle and the radius to it in millimetres, positive to the left; 1 and -1
  // turn on the spot, the ends of the scale are straight.
  const double speed_m_per_s = 1e-3 * first;
  if (second == INT16_MAX || second == INT16_MIN || second == 0) {
    return {speed_m_per_s, speed_m_per_s};
  }
  if (second == 1 || second == -1) return {-second * speed_m_per_s, second * speed_m_per_s};
  const double difference = speed_m_per_s * 0.5 * kTrackM / (1e-3 * second);
  return {speed_m_per_s - difference, speed_m_per_s + difference};
}

}  // namespace

CreateEmulator::CreateEmulator(const CreateEmulatorOptions& options,
                               std::function<CreateWorld()> world)
    : options_(options), world_(std::move(world)), output_(options.baud) {}

void CreateEmulator::on_connection(bool connected, Utime now) {
  if (!std::exchange(started_, true)) now_ = ready_ = now;
  if (connected) parser_.clear();
}

void CreateEmulator::reset(Utime now) {
  run_until(now);
  ready_ = now + Duration::from_seconds(options_.boot_s);
  mode_ = OiMode::off;
  streams_ = false;
  stop_wheels();
  output_.clear();
  left_.reset_counter();
  right_.reset_counter();
}

void CreateEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  run_until(now);
  readable_ = baud == 0 || baud == options_.baud;
  if (!readable_ || asleep_ || now < ready_) return;
  parser_.push(bytes);
  while (const auto request = parser_.next()) obey(*request);
}

void CreateEmulator::obey(const Request& request) {
  // Off, it listens for START alone.
  if (mode_ == OiMode::off && request.opcode != Opcode::start) return;
  const bool may_drive = mode_ == OiMode::safe || mode_ == OiMode::full;
  switch (request.opcode) {
    case Opcode::start:
      mode_ = OiMode::passive;
      stop_wheels();
      break;
    case Opcode::safe:
      mode_ = OiMode::safe;
      break;
    case Opcode::full:
      mode_ = OiMode::full;
      break;
    case Opcode::power_off:
      mode_ = OiMode::passive;
      stop_wheels();
      break;
    case Opcode::stop:
    case Opcode::reset:
      mode_ = OiMode::off;
      streams_ = false;
      stop_wheels();
      break;
    case Opcode::drive:
    case Opcode::drive_wheels:
    case Opcode::drive_pwm: {
      if (!may_drive) break;
      const auto [left, right] = wheels_of(request);
      left_.goal_m_per_s = std::clamp(left, -0.5, 0.5);
      right_.goal_m_per_s = std::clamp(right, -0.5, 0.5);
      break;
    }
    case Opcode::stream:
      streams_ = true;
      streamed_.assign(request.data.begin() + 1, request.data.end());
      next_frame_ = now_ + kFrameEvery;
      break;
    case Opcode::one_packet:
      output_.send(encode_packets(sensors(), request.data), now_);
      break;
    case Opcode::packets:
      output_.send(encode_packets(sensors(), std::span<const uint8_t>(request.data).subspan(1)),
                   now_);
      break;
    case Opcode::pause_stream:
      streams_ = request.data[0] != 0;
      break;
    default:
      break;
  }
}

Sensors CreateEmulator::sensors() const {
  const CreateWorld touch = world();
  Sensors sensors;
  sensors.left_bump = touch.left_bump;
  sensors.right_bump = touch.right_bump;
  sensors.left_drop = touch.left_drop;
  sensors.right_drop = touch.right_drop;
  sensors.cliffs[1] = touch.cliff;
  sensors.charging = touch.on_charger ? 2 : 0;
  sensors.millivolts = options_.millivolts;
  sensors.mode = static_cast<int>(mode_) + options_.mode_offset;
  sensors.left_ticks = left_.ticks(kTickM);
  sensors.right_ticks = right_.ticks(kTickM);
  return sensors;
}

void CreateEmulator::step(double dt_s) {
  const CreateWorld touch = world();
  const bool unsafe = touch.cliff || touch.left_drop || touch.right_drop || touch.on_charger;
  if (unsafe && mode_ == OiMode::safe) {
    mode_ = OiMode::passive;
    stop_wheels();
  }
  for (LaggingWheel* wheel : {&left_, &right_}) wheel->step(dt_s, options_.lag_s);
}

void CreateEmulator::run_until(Utime now) {
  while (started_ && now_ < now) {
    const Utime next = std::min(now, now_ + kStep);
    step((next - now_).seconds());
    now_ = next;
    if (!streams_ || now_ < next_frame_) continue;
    next_frame_ = std::max(next_frame_ + kFrameEvery, now_);
    output_.send(encode_frame(sensors(), streamed_), now_);
  }
}

void CreateEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  run_until(now);
  std::vector<uint8_t> sent;
  output_.advance(now, sent);
  if (!readable_) {
    for (uint8_t& byte : sent) byte = static_cast<uint8_t>(noise_());
  }
  out.insert(out.end(), sent.begin(), sent.end());
}

Utime CreateEmulator::next_event() const {
  return started_ ? std::min(now_ + kStep, output_.next_event()) : kFarFuture;
}

}  // namespace marco::drivers::create
