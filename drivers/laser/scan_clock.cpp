#include "drivers/laser/scan_clock.hpp"

#include <utility>

namespace marco::drivers {

Utime ScanClock::update(Utime end, int64_t dropped) {
  const bool lost = std::exchange(dropped_before_, dropped) != dropped;
  const double device_s = turns_.update(end, lost ? TurnCounter::Gap::any : TurnCounter::Gap::none);
  return filter_.update(device_s, end);
}

void ScanClock::reset() {
  turns_.reset();
  filter_.reset();
}

}  // namespace marco::drivers
