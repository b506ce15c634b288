#include "simulator/devices/leuze/emulator.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::leuze {
namespace {

constexpr double kRangeMaxM = 65.0;

}  // namespace

LaserSweep sweep_of(const LeuzeGeometry& geometry, Utime first_beam, int step) {
  LaserSweep sweep;
  sweep.first_beam = first_beam;
  sweep.beam_interval_s = step * geometry.beam_interval_s();
  sweep.first_bearing_rad = geometry.bearing_rad(1);
  sweep.bearing_step_rad = step * geometry.step_rad();
  sweep.beams = (kLastIndex - 1) / step + 1;
  return sweep;
}

double measured_m(double range_m) {
  return std::isfinite(range_m) ? std::clamp(range_m, 0.0, kRangeMaxM) : kRangeMaxM;
}

LeuzeEmulator::LeuzeEmulator(LaserWorld world, const LeuzeEmulatorOptions& options)
    : world_(std::move(world)), options_(options), output_(options.baud) {
  validate(options, "leuze_emulator");
  require((kLastIndex - 1) % options.step == 0, "the RS4's beam step divides 528");
}

void LeuzeEmulator::on_connection(bool connected, Utime now) {
  connected_ = connected;
  if (!connected) return output_.clear();
  if (start_.us == 0) start_ = now;
  sweep_ = (now - start_).us / Duration::from_seconds(kSweepS).us;
}

void LeuzeEmulator::receive(std::span<const uint8_t> /*bytes*/, int baud, Utime /*now*/) {
  readable_ = baud == 0 || baud == options_.baud;
}

Utime LeuzeEmulator::sweep_end() const {
  return start_ + Duration::from_seconds(static_cast<double>(sweep_ + 1) * kSweepS);
}

void LeuzeEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while (connected_ && now >= sweep_end()) {
    if (output_.free_at() <= sweep_end()) {
      const Utime first_beam = sweep_end() - Duration::from_seconds(kSweepS);
      Telegram telegram;
      telegram.scan_number = static_cast<uint32_t>(sweep_);
      telegram.step = options_.step;
      for (const double range_m : world_(sweep_of(options_.geometry, first_beam, options_.step))) {
        const double value_mm = measured_m(range_m) / options_.geometry.scale * 1000.0;
        telegram.values_mm.push_back(
            static_cast<uint16_t>(std::min(65'534L, std::lround(value_mm / 2.0) * 2)));
      }
      output_.send(encode_telegram(telegram), sweep_end());
      ++scans_sent_;
      last_first_beam_ = first_beam;
    }
    ++sweep_;
  }
  const std::size_t from = out.size();
  output_.advance(now, out);
  if (!readable_) {
    for (std::size_t i = from; i < out.size(); ++i) out[i] = static_cast<uint8_t>(out[i] * 37 | 1);
  }
}

Utime LeuzeEmulator::next_event() const {
  return connected_ ? std::min(output_.next_event(), sweep_end()) : kFarFuture;
}

}  // namespace marco::drivers::leuze
