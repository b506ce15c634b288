#pragma once

#include <chrono>
#include <cstdint>

namespace marco::process {

/// This host's time [us since 1970].
inline int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace marco::process
