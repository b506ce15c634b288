#include "simulator/devices/hokuyo/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace marco::drivers::hokuyo {
namespace {

constexpr uint32_t kNoEcho = 1;  // an error code: below DMIN

}  // namespace

uint32_t HokuyoMirror::clock_ms(Utime now) const {
  return static_cast<uint32_t>((now - power_on_).us / 1000) & 0xFFFFFFU;
}

int64_t HokuyoMirror::turn_after(Utime when) const {
  return static_cast<int64_t>(std::ceil((when - power_on_).seconds() / turn_s()));
}

Utime HokuyoMirror::time_of(int64_t turn, int step) const {
  const int from_rear = step - parameters_.front_step + parameters_.steps_per_turn / 2;
  const Utime start = power_on_ + Duration::from_seconds(static_cast<double>(turn) * turn_s());
  return start + Duration::from_seconds(turn_s() * from_rear / parameters_.steps_per_turn);
}

std::vector<double> HokuyoMirror::ranges_m(int first_step, int last_step, int64_t turn) const {
  const double step_rad = 2.0 * std::numbers::pi / parameters_.steps_per_turn;
  LaserSweep sweep;
  sweep.first_beam = time_of(turn, first_step);
  sweep.beam_interval_s = turn_s() / parameters_.steps_per_turn;
  sweep.first_bearing_rad = (first_step - parameters_.front_step) * step_rad;
  sweep.bearing_step_rad = step_rad;
  sweep.beams = std::max(0, last_step - first_step + 1);
  return world_(sweep);
}

Measurement HokuyoMirror::measure(const ScanRequest& request, int64_t turn) {
  last_first_beam_ = time_of(turn, request.first_step);
  const Utime rear = time_of(turn, parameters_.front_step - parameters_.steps_per_turn / 2);
  Measurement scan;
  scan.timestamp_ms = clock_ms(rear);
  const int64_t largest =
      std::min(parameters_.range_max_mm, request.characters == 3 ? 262'143 : 4095);
  // Of steps that are merged the nearest counts.
  const std::vector<double> steps_m = ranges_m(request.first_step, request.last_step, turn);
  for (int i = 0; i < request.values(); ++i) {
    double range_m = std::numeric_limits<double>::infinity();
    for (int k = i * request.cluster; k < (i + 1) * request.cluster; ++k) {
      const auto step = static_cast<std::size_t>(k);
      if (step < steps_m.size() && steps_m[step] < range_m) range_m = steps_m[step];
    }
    const bool good = std::isfinite(range_m) && range_m >= 0.001 * parameters_.range_min_mm &&
                      std::lround(range_m * 1000.0) <= largest;
    scan.values_mm.push_back(good ? static_cast<uint32_t>(std::lround(range_m * 1000.0)) : kNoEcho);
    // A grey wall's: it falls with the distance. The world has no colours.
    if (request.intensities) {
      scan.intensities.push_back(good ? static_cast<uint32_t>(4000.0 / (1.0 + range_m)) : 0);
    }
  }
  return scan;
}

}  // namespace marco::drivers::hokuyo
