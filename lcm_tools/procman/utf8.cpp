#include "lcm_tools/procman/utf8.hpp"

#include <utility>

namespace marco::procman {
namespace {

constexpr const char* kReplacement = "\xef\xbf\xbd";

enum class Reading { whole, cut, wrong };

/// Looks at the character that begins `text`; `length` is its bytes when whole.
Reading read_character(std::string_view text, std::size_t& length) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  unsigned low = 0x80;
  unsigned high = 0xbf;  // limits of the second byte: no overlong forms, surrogates, beyond 10ffff
  if (first != 0 && first < 0x80) {
    length = 1;
    return Reading::whole;
  }
  if (first >= 0xc2 && first <= 0xdf) {
    length = 2;
  } else if (first >= 0xe0 && first <= 0xef) {
    length = 3;
    if (first == 0xe0) low = 0xa0;
    if (first == 0xed) high = 0x9f;
  } else if (first >= 0xf0 && first <= 0xf4) {
    length = 4;
    if (first == 0xf0) low = 0x90;
    if (first == 0xf4) high = 0x8f;
  } else {
    return Reading::wrong;
  }
  for (std::size_t i = 1; i < length; ++i) {
    if (i == text.size()) return Reading::cut;
    if (byte(i) < low || byte(i) > high) return Reading::wrong;
    low = 0x80;
    high = 0xbf;
  }
  return Reading::whole;
}

}  // namespace

std::string Utf8Cleaner::clean(std::string_view piece) {
  const std::string text = std::exchange(waiting_, {}) + std::string(piece);
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    std::size_t length = 0;
    switch (read_character(std::string_view(text).substr(at), length)) {
      case Reading::whole:
        out.append(text, at, length);
        at += length;
        break;
      case Reading::wrong:
        out += kReplacement;
        ++at;
        break;
      case Reading::cut:
        waiting_ = text.substr(at);
        return out;
    }
  }
  return out;
}

std::string Utf8Cleaner::flush() {
  std::string out;
  for (std::size_t i = std::exchange(waiting_, {}).size(); i > 0; --i) out += kReplacement;
  return out;
}

}  // namespace marco::procman
