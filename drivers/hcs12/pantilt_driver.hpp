#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/hcs12/head_motion.hpp"
#include "drivers/hcs12/line_exchange.hpp"

namespace marco::drivers::hcs12 {

/// Driver of thesis B's pan-tilt board, without port or clock. A move up to poll_limit_clicks is
/// followed by the board's own clicks, a faster one by its ramp, settled at its end. The listing's
/// firmware cannot stop: it is sent to the next unit instead.
class PanTiltDriver {
 public:
  enum class Link { down, homing, up };

  explicit PanTiltDriver(const PanTiltOptions& options);
  PanTiltDriver(const PanTiltDriver&) = delete;
  PanTiltDriver& operator=(const PanTiltDriver&) = delete;

  void on_connection(bool connected, Utime now);
  void receive(std::span<const uint8_t> bytes, Utime now);
  void advance(Utime now, std::vector<uint8_t>& out);
  void command(const PanTiltCommand& command, Utime now);
  /// Appends what stops the board as far as it can be stopped.
  void shut_down(std::vector<uint8_t>& out) const;

  std::vector<PanTiltState> take_states() { return head_.take_states(); }
  Link link() const { return link_; }
  bool moving() const { return phase_ != Phase::idle; }
  std::string state() const;
  int64_t bad_input() const { return exchange_.bad_lines(); }
  int64_t resets() const { return resets_; }

 private:
  enum class Phase { idle, moving, stopping };

  void forget_move(Link link);
  void on_line(const std::string& line, Utime now);
  void on_message(const std::string& line, Utime now);
  void on_status(const PanTiltStatus& status, Utime measured, Utime now);
  void begin(const PanTiltCommand& command, Utime now);
  void begin_stop();
  void stop_at_next_unit();
  void come_to_rest(Utime now);
  void schedule(Utime now);
  void on_timeout(const LineExchange::Request& request, Utime now);
  void ask_status() { exchange_.ask({encode_command('l'), 'l'}); }
  void ask_wait(uint32_t ticks);

  PanTiltOptions options_;
  LineExchange exchange_;
  HeadMotion head_;
  Link link_ = Link::down;
  Phase phase_ = Phase::idle;
  std::optional<PanTiltCommand> next_command_;
  bool waits_ = false;         ///< for the answer of `w`
  bool stop_answered_ = true;  ///< `p` does something on this board; learnt
  Utime next_status_;
  int64_t resets_ = 0;
};

}  // namespace marco::drivers::hcs12
