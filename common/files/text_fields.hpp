#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>

namespace marco::files {

constexpr std::size_t kMaxBeams = 20000;     ///< of a scan in a text; more is damage
constexpr double kUntimedScanPeriodS = 0.1;  ///< between scans of a text without times

/// Reads a line's fields, separated by spaces, tabs or commas, from left to right.
class TextFields {
 public:
  explicit TextFields(std::string_view line) : rest_(line) {}

  /// The next field; empty at the end of the line.
  std::string_view next() {
    const std::size_t start = rest_.find_first_not_of(kSeparators);
    if (start == std::string_view::npos) {
      rest_ = {};
      return {};
    }
    rest_.remove_prefix(start);
    const std::string_view field = rest_.substr(0, rest_.find_first_of(kSeparators));
    rest_.remove_prefix(field.size());
    return field;
  }
  /// The next field as a number (also nan and inf); nothing when it is none.
  template <class Number>
  std::optional<Number> number() {
    const std::string_view field = next();
    Number value{};
    const char* end = field.data() + field.size();
    const auto parsed = std::from_chars(field.data(), end, value);
    if (field.empty() || parsed.ec != std::errc{} || parsed.ptr != end) return std::nullopt;
    return value;
  }

 private:
  static constexpr std::string_view kSeparators = " \t\r\n,;";
  std::string_view rest_;
};

}  // namespace marco::files
