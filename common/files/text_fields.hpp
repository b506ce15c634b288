#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <istream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco::files {

/// As std::getline, but keeps no more than 4 MB of a line (a scan of 100 000 beams is 1 MB): a file
/// that is no text may be one line of gigabytes. @returns false at the end of the file.
inline bool read_line(std::istream& in, std::string& line) {
  constexpr std::size_t kLongest = 4 << 20;
  constexpr int kEnd = std::char_traits<char>::eof();
  line.clear();
  std::streambuf& bytes = *in.rdbuf();
  for (int c = bytes.sbumpc(); c != '\n'; c = bytes.sbumpc()) {
    if (c == kEnd) {
      in.setstate(std::ios::eofbit);
      return !line.empty();
    }
    if (line.size() == kLongest) {
      in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      return true;
    }
    line += static_cast<char>(c);
  }
  return true;
}

constexpr std::size_t kMaxBeams = 20000;     ///< of a scan in a text; more is damage
constexpr double kUntimedScanPeriodS = 0.1;  ///< between scans of a text without times

/// Reads a line's fields, separated by spaces, tabs or commas, from left to right.
class TextFields {
 public:
  explicit TextFields(std::string_view line) : rest_(line) {}

  /// The next field; empty at the end of the line.
  std::string_view next() {
    const char* at = rest_.data();
    const char* const end = at + rest_.size();
    while (at != end && separates(*at)) ++at;
    const char* const first = at;
    while (at != end && !separates(*at)) ++at;
    rest_ = {at, static_cast<std::size_t>(end - at)};
    return {first, static_cast<std::size_t>(at - first)};
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
  // Logs are read at a hundred instructions a number: find_first_of() would take three hundred
  // more.
  static bool separates(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == ';';
  }
  std::string_view rest_;
};

/// All fields of a line as numbers; what follows a `#` is passed over.
/// @param place  names the line in messages, "path:3".
/// @throws std::invalid_argument where a field is no finite number.
inline std::vector<double> finite_numbers(std::string_view line, const std::string& place) {
  std::vector<double> numbers;
  TextFields fields(line.substr(0, line.find('#')));
  for (std::string_view field = fields.next(); !field.empty(); field = fields.next()) {
    const auto number = TextFields(field).number<double>();
    require(number && std::isfinite(*number),
            place + ": '" + std::string(field.substr(0, 40)) + "' is not a finite number");
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace marco::files
