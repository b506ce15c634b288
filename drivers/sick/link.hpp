#pragma once

#include <chrono>
#include <optional>

#include "drivers/laser/laser_driver.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/transport/baud_search.hpp"
#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::sick {

/// The line to the laser: its speed and the telegrams on it.
class SickLink {
 public:
  /// @param stream  outlives the link. @param wanted_baud  to measure at
  SickLink(ByteStream& stream, int wanted_baud, Clock clock);

  /// Changes to the next baud rate at which the laser may listen. A rate that the port cannot do is
  /// left out. @returns why one was, or "". @throws std::invalid_argument when none is left.
  std::string try_next_baud_rate();
  void restart_search() { search_.restart(); }
  /// Changes to the rate to measure at: the laser has changed, too.
  void use_goal_baud();
  /// The laser did not answer at the goal. @returns whether this was once too often: the goal is
  /// 9600 from now on.
  bool fall_back();

  void send(const Bytes& telegram);
  struct Received {
    Utime arrival;
    bool gap = false;  ///< the line fell silent inside a telegram
  };
  /// Waits for bytes, `timeout` at most.
  Received receive(std::chrono::microseconds timeout);
  /// The next event in what was received.
  std::optional<Event> next() { return parser_.next(); }
  void flush() { parser_.clear(); }

  int baud() const { return baud_; }
  int goal_baud() const { return goal_baud_; }
  int64_t garbage_bytes() const { return parser_.garbage_bytes(); }

 private:
  void set_baud(int baud);

  ByteStream& stream_;
  Clock clock_;
  TelegramParser parser_{TelegramParser::Side::laser};
  BaudSearch search_;
  int baud_ = 0;  ///< of our side
  int goal_baud_;
  int failures_ = 0;  ///< at the goal
  Utime last_byte_;
};

}  // namespace marco::drivers::sick
