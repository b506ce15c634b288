#pragma once

#include <cstdio>
#include <string>

namespace marco::slam {

/// printf into a string, of any length.
template <class... Values>
std::string print(const char* format, Values... values) {
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, format, values...);
  return text;
}

}  // namespace marco::slam
