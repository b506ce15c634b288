#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace marco::procman {

/// Which bytes of a command's file a text is.
struct OutputSpan {
  std::string id;
  int64_t first_byte = -1;  ///< -1: not of the file
  int64_t end_byte = -1;
  std::string file;
};

/// The last lines of each command's output, as a sheriff received them. Bounded, whatever comes: to
/// kMaxCommandBytes per command and kMaxBytes in all; lines longer than kMaxLineBytes are cut.
/// Where a message was lost, a line says how much is missing and where to find it, if the deputy
/// announces the bytes it sends (as ours do).
class OutputLog {
 public:
  /// @param max_lines kept of each command.
  explicit OutputLog(std::size_t max_lines = 5000) : max_lines_(max_lines) {}
  static constexpr std::size_t kMaxLineBytes = std::size_t{16} << 10;
  static constexpr std::size_t kMaxCommandBytes = std::size_t{4} << 20;
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;

  /// Announces what the message of this deputy and time will carry.
  void on_span(const std::string& deputy, int64_t utime_us, std::vector<OutputSpan> spans);

  /// One message. `texts` in the order of `ids`.
  /// @returns the lines completed by it, as "id", "line".
  std::vector<std::pair<std::string, std::string>> on_output(const std::string& deputy,
                                                             int64_t utime_us,
                                                             const std::vector<std::string>& ids,
                                                             const std::vector<std::string>& texts);

  /// Lines so far, the last one perhaps unfinished.
  const std::deque<std::string>& lines(const std::string& id) const;

  int64_t lost_bytes() const { return lost_bytes_; }

  /// Of all lines kept.
  std::size_t bytes() const { return bytes_; }

 private:
  struct Buffer {
    std::deque<std::string> lines;
    std::size_t bytes = 0;
    std::optional<int64_t> expected_byte;
    std::string file;
  };
  struct Announced {
    int64_t utime_us = 0;
    std::vector<OutputSpan> spans;
  };

  using Completed = std::vector<std::pair<std::string, std::string>>;
  void append(const std::string& id, std::string_view text, Completed& completed);
  void end_line(const std::string& id, Buffer& buffer, Completed& completed);
  void drop_oldest(Buffer& buffer);
  void drop_of_longest();

  std::size_t max_lines_;
  std::map<std::string, Buffer> buffers_;
  std::map<std::string, Announced> announced_;  ///< by deputy
  std::size_t bytes_ = 0;
  int64_t lost_bytes_ = 0;
};

/// `line` without terminal control sequences and other unprintable characters.
std::string printable(const std::string& line);

}  // namespace marco::procman
