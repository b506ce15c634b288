#pragma once

#include <optional>

#include "drivers/hcs12/drive_run.hpp"
#include "drivers/hcs12/line_exchange.hpp"

namespace marco::drivers::hcs12 {

/// What the base's driver asks of its board to move the wheels and to follow them.
class BoardCommands {
 public:
  /// @param exchange outlives it.
  explicit BoardCommands(LineExchange& exchange) : exchange_(exchange) {}

  void status() { exchange_.ask({encode_command('l'), 'l'}); }
  void status_first() { exchange_.ask_first({encode_command('l'), 'l'}); }
  /// Drops what is queued.
  void stop();
  /// A ramp the board has already is not sent again.
  void ramp_if_new(const Ramp& ramp);
  void ramp(const Ramp& ramp);
  void run(const RunOrder& order);
  /// `w`: the board answers when the wheels rest, at the latest after the rest of the walk.
  void wait_for_rest(const RampWalk& walk, Utime now);

  bool waits() const { return wait_until_.has_value(); }
  void end_wait() { wait_until_.reset(); }
  /// When the answer of `w` was lost, or the board is: asks for the status instead.
  bool give_up_wait(Utime now);
  int64_t lost_waits() const { return lost_waits_; }

  /// Asks for the status when it is due and nothing else is on the line. @returns whether it did.
  bool poll(Utime now, double period_s);
  void poll_at(Utime when) { next_status_ = when; }

  /// Nothing is queued or awaited.
  bool quiet() const { return exchange_.quiet(); }
  char awaited() const { return exchange_.awaited(); }
  void clear_queue() { exchange_.clear_queue(); }

 private:
  LineExchange& exchange_;
  std::optional<Ramp> ramp_;  ///< as last sent
  std::optional<Utime> wait_until_;
  Utime next_status_;
  int64_t lost_waits_ = 0;
};

}  // namespace marco::drivers::hcs12
