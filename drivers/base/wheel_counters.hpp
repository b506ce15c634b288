#pragma once

#include <cstdint>
#include <optional>

#include "drivers/base/click_odometry.hpp"

namespace marco::drivers {

/// The counters of two wheels, 16 bits each, that wrap.
class WheelCounters {
 public:
  explicit WheelCounters(double tick_m) : tick_m_(tick_m) {}

  /// What the wheels did since the last call. Nothing at the first one, nor where a wheel would
  /// have rolled faster than 2 m/s: then its counter was reset.
  /// @param step_s  since the last call, > 0
  ClickOdometry::Step count(uint16_t left, uint16_t right, double step_s);
  /// The next counts have nothing to do with the last ones.
  void forget() { last_.reset(); }
  int64_t implausible() const { return implausible_; }

 private:
  struct Counts {
    uint16_t left = 0, right = 0;
  };
  double tick_m_;
  std::optional<Counts> last_;
  int64_t implausible_ = 0;
};

}  // namespace marco::drivers
