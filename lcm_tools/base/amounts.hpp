#pragma once

#include <cmath>
#include <string>

#include "lcm_tools/base/format.hpp"

/// Amounts as a person reads them.
namespace marco {

inline std::string size_text(double bytes) {
  if (bytes < 1e3) return format("%.0f B", bytes);
  if (bytes < 1e6) return format("%.1f kB", bytes * 1e-3);
  if (bytes < 1e9) return format("%.1f MB", bytes * 1e-6);
  return format("%.2f GB", bytes * 1e-9);
}

inline std::string span_text(double seconds) {
  const double size = std::abs(seconds);
  if (size < 1e-3) return format("%.0f us", seconds * 1e6);
  if (size < 1.0) return format("%.1f ms", seconds * 1e3);
  if (size < 600.0) return format("%.2f s", seconds);
  if (size < 172800.0) return format("%.2f h", seconds / 3600.0);
  return format("%.1f days", seconds / 86400.0);
}

}  // namespace marco
