#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace marco {

/// As std::vprintf, into a string.
[[gnu::format(printf, 1, 0)]] inline std::string format_values(const char* pattern,
                                                               va_list values) {
  va_list again;
  va_copy(again, values);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, pattern, again)), '\0');
  va_end(again);
  std::vsnprintf(text.data(), text.size() + 1, pattern, values);
  return text;
}

/// As std::printf, into a string.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  va_list values;
  va_start(values, pattern);
  std::string text = format_values(pattern, values);
  va_end(values);
  return text;
}

}  // namespace marco
