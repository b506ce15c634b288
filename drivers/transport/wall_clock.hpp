#pragma once

#include <chrono>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// This host's time of day.
inline Utime wall_now() {
  return Utime::from_us(std::chrono::duration_cast<std::chrono::microseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count());
}

/// Later than anything: the next event of a device that only waits.
inline constexpr Utime kFarFuture = Utime::from_us(INT64_MAX / 4);

}  // namespace marco::drivers
