#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// The transmitter of an emulated serial line at 8N1: ten bits a byte. Baud 0 = no serial line
/// (TCP): everything leaves at once.
class PacedOutput {
 public:
  explicit PacedOutput(int baud = 0) : baud_(baud) {}

  /// Holds for what is sent from now on.
  void set_baud(int baud) { baud_ = baud; }
  int baud() const { return baud_; }

  /// Queues `bytes`. The first leaves at `earliest`, or when all queued before it have left.
  void send(std::span<const uint8_t> bytes, Utime earliest);

  /// Appends what has left the line by `now`.
  void advance(Utime now, std::vector<uint8_t>& out);

  /// When to call advance() next: at the end of the telegram on the line, or in two milliseconds
  /// inside a long one; the far future when nothing is queued.
  Utime next_event() const;

  /// When the line will be free.
  Utime free_at() const { return free_at_; }
  bool empty() const { return queue_.empty(); }
  void clear();

 private:
  struct Telegram {
    std::vector<uint8_t> bytes;
    Utime start;
    int baud;
    std::size_t sent = 0;

    Utime end_of(std::size_t count) const;
  };
  int baud_;
  std::deque<Telegram> queue_;
  Utime free_at_;
  Utime last_advance_;
};

/// Time `bytes` take on a serial line at 8N1. @param baud 0 = none.
inline Duration line_time(std::size_t bytes, int baud) {
  return Duration::from_us(baud > 0 ? static_cast<int64_t>(bytes) * 10'000'000 / baud : 0);
}

}  // namespace marco::drivers
