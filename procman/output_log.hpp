#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace marco::procman {

/// Which bytes of a command's file a text is.
struct OutputSpan {
  std::string id;
  int64_t first_byte = -1;  ///< -1: not of the file
  int64_t end_byte = -1;
  std::string file;
};

/// The last lines of each command, as a sheriff heard them. Where a message was lost on the way, a
/// line says how much is missing and where it is, if the deputy is one that says which bytes it
/// sends (ours).
class OutputLog {
 public:
  /// @param max_lines kept of each command.
  explicit OutputLog(std::size_t max_lines) : max_lines_(max_lines) {}

  /// What the message of this deputy and time will carry; comes before it.
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

 private:
  struct Buffer {
    std::deque<std::string> lines;
    std::optional<int64_t> expected_byte;
    std::string file;
  };
  struct Announced {
    int64_t utime_us = 0;
    std::vector<OutputSpan> spans;
  };

  void append(const std::string& id,
              const std::string& text,
              std::vector<std::pair<std::string, std::string>>& completed);

  std::size_t max_lines_;
  std::map<std::string, Buffer> buffers_;
  std::map<std::string, Announced> announced_;  ///< by deputy
  int64_t lost_bytes_ = 0;
};

/// `line` without terminal control sequences and other characters that would not stay on a line.
std::string printable(const std::string& line);

}  // namespace marco::procman
