#pragma once

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// The stamp of a received message. Two such stamps can be subtracted, and durations added, without
/// overflow. @throws std::invalid_argument more than 2^61 us (73 000 years) from 1970.
inline Utime stamp_of(int64_t utime_us) {
  constexpr int64_t kFarthestUs = int64_t{1} << 61;
  require(utime_us > -kFarthestUs && utime_us < kFarthestUs,
          "a stamp more than 73000 years from 1970");
  return Utime::from_us(utime_us);
}

}  // namespace marco
