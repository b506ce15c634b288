#include "simulator/devices/ldlidar/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"

namespace marco::drivers::ldlidar {
namespace {

constexpr int kIntensity = 200;
constexpr int kFirstStampMs = 28'500;  // the stamps wrap soon

}  // namespace

LdlidarEmulatorOptions stl27l() { return {921'600, 21'600.0, 10.0, 2.0, 25.0}; }

LdlidarEmulator::LdlidarEmulator(LaserWorld world, const LdlidarEmulatorOptions& options)
    : world_(std::move(world)), options_(options), output_(options.baud) {
  validate(options, "ldlidar_emulator");
}

void LdlidarEmulator::on_connection(bool /*connected*/, Utime now) {
  // The first client finds it running.
  if (!on_) start_ = now;
  on_ = true;
}

void LdlidarEmulator::receive(std::span<const uint8_t> /*bytes*/, int baud, Utime /*now*/) {
  client_baud_ = baud;
}

void LdlidarEmulator::power_cycle(Utime now) {
  output_.clear();
  on_ = true;
  start_ = now + Duration::from_seconds(options_.power_on_s);
  next_sample_ = 0;
}

Utime LdlidarEmulator::sample_time(int64_t sample) const {
  return start_ + Duration::from_seconds(static_cast<double>(sample) / options_.samples_per_s);
}

double LdlidarEmulator::angle_deg(int64_t sample) const {
  const double turns = static_cast<double>(sample) / options_.samples_per_s * options_.turns_per_s;
  return (turns - std::floor(turns)) * 360.0;
}

void LdlidarEmulator::send_packet() {
  const double step_deg = 360.0 * options_.turns_per_s / options_.samples_per_s;
  LaserSweep sweep;
  sweep.first_beam = sample_time(next_sample_);
  sweep.beam_interval_s = 1.0 / options_.samples_per_s;
  sweep.first_bearing_rad = -deg_to_rad(angle_deg(next_sample_));
  sweep.bearing_step_rad = -deg_to_rad(step_deg);
  sweep.beams = kPacketSamples;
  const std::vector<double> ranges_m = world_(sweep);
  Packet packet;
  packet.speed_deg_per_s = static_cast<int>(std::lround(360.0 * options_.turns_per_s));
  const auto cdeg = [this](int64_t sample) {
    return static_cast<int>(std::lround(100.0 * angle_deg(sample))) % 36'000;
  };
  packet.start_cdeg = cdeg(next_sample_);
  packet.end_cdeg = cdeg(next_sample_ + kPacketSamples - 1);
  for (std::size_t i = 0; i < kPacketSamples; ++i) {
    const double range_m = i < ranges_m.size() ? ranges_m[i] : 0.0;
    if (!std::isfinite(range_m) || range_m > options_.range_max_m) continue;
    packet.samples[i] = {static_cast<int>(std::lround(1e3 * range_m)), kIntensity};
  }
  next_sample_ += kPacketSamples;
  const double runs_s = (sample_time(next_sample_ - 1) - start_).seconds();
  packet.stamp_ms =
      static_cast<int>((kFirstStampMs + static_cast<int64_t>(runs_s * 1e3)) % kStampWrapMs);
  output_.send(encode_packet(packet), sample_time(next_sample_));
}

void LdlidarEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while (on_ && now >= sample_time(next_sample_ + kPacketSamples)) send_packet();
  const std::size_t before = out.size();
  output_.advance(now, out);
  if (client_baud_ == 0 || client_baud_ == options_.baud) return;
  for (std::size_t i = before; i < out.size(); ++i) out[i] = static_cast<uint8_t>(noise_());
}

Utime LdlidarEmulator::next_event() const {
  const Utime next = output_.next_event();
  return on_ ? std::min(next, sample_time(next_sample_ + kPacketSamples)) : next;
}

}  // namespace marco::drivers::ldlidar
