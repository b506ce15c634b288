#pragma once

#include <map>
#include <string>

namespace marco::testing {

/// Packs as LZF does: literals, and copies of what came up to 8 kB before. Slow.
inline std::string pack_lzf(const std::string& bytes) {
  constexpr std::size_t kLongest = 264, kFarthest = 8192;
  std::string packed, literals;
  const auto flush = [&] {
    if (literals.empty()) return;
    packed += static_cast<char>(literals.size() - 1);
    packed += literals;
    literals.clear();
  };
  std::map<std::string, std::size_t> last;  // where three bytes were seen
  for (std::size_t at = 0; at < bytes.size();) {
    const std::string three = bytes.substr(at, 3);
    const auto seen = three.size() == 3 ? last.find(three) : last.end();
    std::size_t length = 0;
    if (seen != last.end() && at - seen->second <= kFarthest) {
      while (length < kLongest && at + length < bytes.size() &&
             bytes[seen->second + length] == bytes[at + length]) {
        ++length;
      }
      flush();
      const std::size_t distance = at - seen->second - 1, code = length - 2;
      packed += static_cast<char>((code < 7 ? code : 7) << 5U | distance >> 8U);
      if (code >= 7) packed += static_cast<char>(code - 7);
      packed += static_cast<char>(distance & 255U);
    } else {
      length = 1;
      literals += bytes[at];
      if (literals.size() == 32) flush();
    }
    last[three] = at;
    at += length;
  }
  flush();
  return packed;
}

}  // namespace marco::testing
