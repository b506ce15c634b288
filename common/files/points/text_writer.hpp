#pragma once

#include <charconv>
#include <string>
#include <string_view>

namespace marco::files {

/// Numbers as text.
class TextWriter {
 public:
  /// In as few digits as give the same number when read, then `after`.
  template <class Number>
  void number(Number value, char after) {
    append(after, value);
  }
  /// With this many decimals.
  void fixed(double value, int decimals, char after) {
    append(after, value, std::chars_format::fixed, decimals);
  }
  std::string_view text() const { return text_; }
  void clear() { text_.clear(); }

 private:
  template <class... How>
  void append(char after, How... how) {
    char digits[400];  // fixed: a double has at most 309 before the point
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, how...).ptr);
    text_ += after;
  }

  std::string text_;
};

}  // namespace marco::files
