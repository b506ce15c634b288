#pragma once

#include <stdexcept>
#include <string>

namespace marco {

/// The caller's mistake, bad configuration or impossible geometry.
/// @param message names value, unit and limit.
/// @throws std::invalid_argument unless `condition`.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

/// As above without building a string on the good path.
inline void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

}  // namespace marco
