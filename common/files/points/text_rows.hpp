#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace marco::files {

/// The lines of a text that hold something: comments (after # or //) and blank lines are passed
/// over. A copy continues from the same line.
class TextRows {
 public:
  /// @param text  outlives this
  /// @param name  of the file, for messages; outlives this
  TextRows(std::string_view text, const std::string& name) : rest_(text), name_(&name) {}

  /// Goes to the next line. @returns false at the end.
  bool next();
  std::string_view line() const { return line_; }
  /// Reads numbers (also nan and inf) from the line's beginning, separated by blanks, tabs, commas
  /// or semicolons, until `into` is full or something else comes. @returns how many.
  std::size_t numbers(std::span<double> into) const;
  std::size_t bytes_left() const { return rest_.size(); }

  /// @throws std::invalid_argument "NAME:LINE: what".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view rest_, line_;
  const std::string* name_;
  std::size_t number_ = 0;
};

/// What separates the fields of a line.
constexpr bool separates_fields(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

}  // namespace marco::files
