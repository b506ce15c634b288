#include "simulator/devices/kobuki/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::kobuki {
namespace {

constexpr Duration kStep = Duration::from_us(5000);
constexpr Duration kFrameEvery = Duration::from_us(20'000);
constexpr double kTickM = 1.0 / kTicksPerM;
constexpr double kMostMPerS = 0.7;

int16_t counts(double value, double of_one) {
  return static_cast<int16_t>(std::lround(std::clamp(value / of_one, -32'767.0, 32'767.0)));
}

}  // namespace

KobukiEmulator::KobukiEmulator(const KobukiEmulatorOptions& options,
                               std::function<KobukiWorld()> world)
    : options_(options), world_(std::move(world)), output_(kBaud) {}

void KobukiEmulator::on_connection(bool connected, Utime now) {
  if (!std::exchange(started_, true)) born_ = ready_ = now_ = next_frame_ = now;
  if (connected) parser_.clear();
}

void KobukiEmulator::reset(Utime now) {
  run_until(now);
  born_ = ready_ = now + Duration::from_seconds(options_.boot_s);
  output_.clear();
  for (LaggingWheel* wheel : {&left_, &right_}) {
    wheel->goal_m_per_s = 0.0;
    wheel->reset_counter();
  }
  heading_rad_ = 0.0;
}

void KobukiEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  run_until(now);
  if ((baud != 0 && baud != kBaud) || now < ready_) return;
  parser_.push(bytes);
  while (const auto received = parser_.next()) {
    if (const auto order = decode_order(received->payload)) obey(*order);
  }
}

void KobukiEmulator::obey(const Order& order) {
  tells_versions_ = tells_versions_ || order.asks_versions;
  if (!order.velocity_m_per_s) return;
  const double turn_m_per_s = order.yaw_rate_rad_per_s * kTrackM / 2.0;
  left_.goal_m_per_s = std::clamp(*order.velocity_m_per_s - turn_m_per_s, -kMostMPerS, kMostMPerS);
  right_.goal_m_per_s = std::clamp(*order.velocity_m_per_s + turn_m_per_s, -kMostMPerS, kMostMPerS);
}

Feedback KobukiEmulator::feedback() {
  const KobukiWorld touch = world_ ? world_() : KobukiWorld{};
  Feedback told;
  told.clock_ms = static_cast<uint16_t>((now_ - born_).us / 1000);
  told.bumpers = touch.bumpers;
  told.hanging_wheels = touch.hanging_wheels;
  told.cliffs = touch.cliffs;
  told.charger = touch.charger;
  told.left_ticks = left_.ticks(kTickM);
  told.right_ticks = right_.ticks(kTickM);
  told.decivolts = static_cast<uint8_t>(options_.decivolts);
  const double rate_deg_per_s = rad_to_deg((right_.speed_m_per_s - left_.speed_m_per_s) / kTrackM) +
                                options_.gyro_bias_deg_per_s;
  told.heading_cdeg = counts(rad_to_deg(normalize_angle(heading_rad_)), 0.01);
  told.rate_cdeg_per_s = counts(rate_deg_per_s, 0.01);
  told.gyro.assign(2, {0, 0, counts(rate_deg_per_s, kGyroDegPerS)});
  if (std::exchange(tells_versions_, false)) told.firmware = {1, 2, 0};
  return told;
}

void KobukiEmulator::run_until(Utime now) {
  while (started_ && now_ < now) {
    const Utime next = std::min(now, now_ + kStep);
    const double dt_s = (next - now_).seconds();
    for (LaggingWheel* wheel : {&left_, &right_}) wheel->step(dt_s, options_.lag_s);
    heading_rad_ += dt_s * (right_.speed_m_per_s - left_.speed_m_per_s) / kTrackM;
    now_ = next;
    if (now_ < next_frame_ || now_ < ready_) continue;
    next_frame_ = std::max(next_frame_ + kFrameEvery, now_);
    output_.send(encode_frame(feedback()), now_);
  }
}

void KobukiEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  run_until(now);
  output_.advance(now, out);
}

Utime KobukiEmulator::next_event() const {
  return started_ ? std::min(now_ + kStep, output_.next_event()) : kFarFuture;
}

}  // namespace marco::drivers::kobuki
