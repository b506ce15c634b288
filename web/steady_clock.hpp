#pragma once

#include <chrono>

namespace marco::web {

/// Seconds of a clock that never steps back.
inline double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace marco::web
