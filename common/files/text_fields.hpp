#pragma once

#include <charconv>
#include <cstddef>
#include <istream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::files {

constexpr std::size_t kLongestLine = 4 << 20;
constexpr std::size_t kMaxBeams = 100'000;   ///< of a scan, 1 MB of text; more is damage
constexpr double kUntimedScanPeriodS = 0.1;  ///< between the scans of a file without times

/// As std::getline, but a line of more than 4 MB comes as several: a binary file may be one of
/// gigabytes. @returns false at the end of the file.
inline bool read_line(std::istream& in, std::string& line) {
  constexpr int kEnd = std::char_traits<char>::eof();
  line.clear();
  std::streambuf& bytes = *in.rdbuf();
  for (int c = bytes.sbumpc(); c != '\n'; c = bytes.sbumpc()) {
    if (c == kEnd) {
      in.setstate(std::ios::eofbit);
      return !line.empty();
    }
    line += static_cast<char>(c);
    if (line.size() == kLongestLine) return true;
  }
  return true;
}

/// Reads a line's fields, separated by spaces, tabs, commas or semicolons, from left to right.
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
  /// The next field as a number (also nan and inf); nothing where it is not a number.
  template <class Number>
  std::optional<Number> number() {
    const std::string_view field = next();
    Number value{};
    const char* end = field.data() + field.size();
    const auto parsed = std::from_chars(field.data(), end, value);
    if (field.empty() || parsed.ec != std::errc{} || parsed.ptr != end) return std::nullopt;
    return value;
  }
  // Logs are read at a hundred instructions a number: find_first_of() would take three hundred
  // more.
  static bool separates(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == ';';
  }

 private:
  std::string_view rest_;
};

/// The lines of a text. A copy continues from the same line.
class TextRows {
 public:
  /// @param text  outlives this
  /// @param name  of the file, for messages; outlives this
  TextRows(std::string_view text, const std::string& name) : rest_(text), name_(&name) {}

  /// Goes to the next line. @returns false at the end.
  bool next_line();
  /// Goes to the next line that holds something: comments (after # or //) and blank lines are
  /// ignored. @returns false at the end.
  bool next();
  std::string_view line() const { return line_; }
  /// Reads numbers (also nan and inf) from the line's beginning until `into` is full or something
  /// else comes. @returns how many.
  std::size_t numbers(std::span<double> into) const;
  std::size_t bytes_left() const { return rest_.size(); }

  /// "NAME:LINE", for messages.
  std::string place() const { return *name_ + ":" + std::to_string(number_); }
  /// @throws std::invalid_argument "NAME:LINE: what".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view rest_, line_;
  const std::string* name_;
  std::size_t number_ = 0;
};

/// A line of a file of numbers.
struct NumericRow {
  std::string place;  ///< "path:3", for messages
  std::vector<double> numbers;
};

/// The lines of a file of numbers; what follows a `#` and empty lines are skipped.
/// @throws std::invalid_argument naming file and line where a field is no finite number, and as
/// read_whole_file().
std::vector<NumericRow> read_numeric_rows(const std::string& path);

}  // namespace marco::files
