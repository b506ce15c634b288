#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace marco::drivers {

/// Cuts bytes into lines at LF, drops CR; a line longer than the limit is garbage and dropped.
class LineCutter {
 public:
  static constexpr std::size_t kMaxLine = 256;
  /// @param max_line  characters without LF
  explicit LineCutter(std::size_t max_line = kMaxLine) : max_line_(max_line) {}

  /// @returns the line that this byte ends.
  std::optional<std::string> push(uint8_t byte) {
    if (byte == '\r') return std::nullopt;
    if (byte == '\n') {
      std::string line = std::exchange(line_, {});
      if (std::exchange(skipping_, false)) return std::nullopt;
      return line;
    }
    if (skipping_) return std::nullopt;
    if (line_.size() >= max_line_) {
      skipping_ = true;
      ++overlong_;
      line_.clear();
      return std::nullopt;
    }
    line_ += static_cast<char>(byte);
    return std::nullopt;
  }
  void clear() { line_.clear(); }
  int64_t overlong() const { return overlong_; }

 private:
  std::size_t max_line_;
  std::string line_;
  bool skipping_ = false;
  int64_t overlong_ = 0;
};

}  // namespace marco::drivers
