#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace marco {

/// As std::printf, at most 511 bytes.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  char text[512];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

}  // namespace marco
