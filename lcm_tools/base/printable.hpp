#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "lcm_tools/base/format.hpp"

/// What anybody may have written, fit for a terminal, a journal or a log: names of channels and
/// files, texts of messages.
namespace marco {

/// Takes one character of UTF-8 from the front. U+FFFD: a byte that is none, which is taken alone.
inline char32_t take_character(std::string_view& text) {
  constexpr char32_t kNone = 0xFFFD;
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xC2 ? 0
                             : lead < 0xE0 ? 2
                             : lead < 0xF0 ? 3
                             : lead < 0xF5 ? 4
                                           : 0;
  char32_t code = length == 1 ? lead : lead & (0xFFU >> (length + 1));
  bool is_good = length > 0 && length <= text.size();
  for (std::size_t i = 1; is_good && i < length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    is_good = (byte & 0xC0U) == 0x80;
    code = code << 6U | (byte & 0x3FU);
  }
  // Longer than need be, half of a pair, beyond the last one.
  is_good = is_good && !(length == 3 && code < 0x800) && !(length == 4 && code < 0x10000) &&
            !(code >= 0xD800 && code < 0xE000) && code < 0x110000;
  text.remove_prefix(is_good ? length : 1);
  return is_good ? code : kNone;
}

/// Whether a terminal draws it and does nothing else: no control character, and none that turns the
/// direction of writing or begins a line.
inline bool is_drawn(char32_t code) {
  const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  const bool turns = code == 0x61C || code == 0x200E || code == 0x200F ||
                     (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return !is_control && !turns;
}

/// Ends of lines: as escapes; as they are; with the lines after the first set in, so that none
/// looks like a message of its own.
enum class Newline { escaped, kept, set_in };

/// The text with invisible characters and invalid UTF-8 as escapes.
/// @param most  bytes of the result
inline std::string printable(std::string_view text,
                             Newline newline = Newline::escaped,
                             std::size_t most = std::string::npos) {
  std::string shown;
  while (!text.empty()) {
    const std::string_view before = text;
    const char32_t code = take_character(text);
    const std::string_view bytes = before.substr(0, before.size() - text.size());
    const bool is_text = is_drawn(code) || (code == '\t' && newline != Newline::escaped);
    std::string piece(bytes);
    if (code == '\n' && newline != Newline::escaped) {
      if (newline == Newline::set_in && !text.empty() && text.front() != ' ') piece += "  ";
    } else if (bytes.size() == 1 && (code == 0xFFFD || !is_text)) {
      piece = format("\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(bytes[0])));
    } else if (!is_text) {
      piece = format("\\u%04x", static_cast<unsigned>(code));
    }
    if (shown.size() + piece.size() > most) break;
    shown += piece;
  }
  return shown;
}

/// As std::fprintf, printable.
[[gnu::format(printf, 2, 3)]] inline void print(std::FILE* to, const char* pattern, ...) {
  va_list values;
  va_start(values, pattern);
  std::fputs(printable(format_values(pattern, values), Newline::kept).c_str(), to);
  va_end(values);
}

}  // namespace marco
