#include "drivers/base/wheel_counters.hpp"

#include <cstdlib>

namespace marco::drivers {
namespace {

constexpr double kFastestMPerS = 2.0;
constexpr double kSpareTicks = 10.0;  // frames may come several at once

int difference(uint16_t now, uint16_t before) {
  return static_cast<int16_t>(static_cast<uint16_t>(now - before));
}

}  // namespace

ClickOdometry::Step WheelCounters::count(uint16_t left, uint16_t right, double step_s) {
  const Counts before = last_.value_or(Counts{left, right});
  last_ = {left, right};
  const int left_ticks = difference(left, before.left);
  const int right_ticks = difference(right, before.right);
  const double most = kFastestMPerS * step_s / tick_m_ + kSpareTicks;
  if (std::abs(left_ticks) > most || std::abs(right_ticks) > most) {
    ++implausible_;
    return {};
  }
  return {static_cast<double>(left_ticks), static_cast<double>(right_ticks),
          left_ticks * tick_m_ / step_s, right_ticks * tick_m_ / step_s};
}

}  // namespace marco::drivers
