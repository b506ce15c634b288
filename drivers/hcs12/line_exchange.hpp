#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/hcs12/codec.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::hcs12 {

/// The host's side of a board that keeps one line: sends a command, waits for its reply, then sends
/// the next. While the board does not answer it is asked every half second.
class LineExchange {
 public:
  struct Request {
    std::string line;
    char reply = '\0';         ///< letter the reply begins with; 0 = none is expected
    double patience_s = 0.25;  ///< beyond the time of the line itself
  };

  /// The serial line was opened or lost.
  void on_connection(bool connected, Utime now);
  bool connected() const { return connected_; }

  void ask(Request request) { queue_.push_back(std::move(request)); }
  void ask_first(Request request) { queue_.push_front(std::move(request)); }
  void clear_queue() { queue_.clear(); }
  void clear();
  bool quiet() const { return queue_.empty() && !outstanding_; }

  /// @returns the lines that have come to their ends.
  std::vector<std::string> receive(std::span<const uint8_t> bytes);
  /// The letter that is waited for, 0 = none.
  char awaited() const { return outstanding_ ? outstanding_->reply : '\0'; }
  void answered() { outstanding_.reset(); }
  /// A part of the reply came.
  void extend(Utime now) { sent_ = now; }

  /// Sends the next command when none is outstanding.
  /// @returns the request that has waited too long, if one has.
  std::optional<Request> advance(Utime now, std::vector<uint8_t>& out);

  /// A line was understood, or not.
  void accept() { timeouts_in_a_row_ = 0; }
  void reject() { ++bad_lines_; }
  int64_t bad_lines() const { return bad_lines_ + cutter_.overlong(); }
  /// Counts a request that was not answered. @returns whether the board is silent.
  bool is_silent_after_timeout() { return ++timeouts_in_a_row_ >= 3; }

  /// Whether the board is to be asked if it is there.
  bool ping_due(Utime now);
  void ping_at(Utime when) { next_ping_ = when; }
  void ping_later(Utime now);

 private:
  LineCutter cutter_;
  std::deque<Request> queue_;
  std::optional<Request> outstanding_;
  Utime sent_;
  Utime next_ping_;
  bool connected_ = false;
  int timeouts_in_a_row_ = 0;
  int64_t bad_lines_ = 0;
};

/// When the board began to print a line whose end has just come: that is when it was measured.
inline Utime line_begun(std::size_t length_without_lf, Utime end) {
  return end - Duration::from_us(
                   static_cast<int64_t>(kByteUs * static_cast<double>(length_without_lf + 1)));
}

}  // namespace marco::drivers::hcs12
