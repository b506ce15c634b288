#pragma once

#include <functional>
#include <string>

#include "drivers/textbase/codec.hpp"
#include "drivers/transport/line_cutter.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::textbase {

struct TextBoardOptions {
  double boot_s = 1.0;            ///< from power or reset until it says what it is
  double lag_s = 0.03;            ///< time constant of its wheels
  int millivolts = 7400;          ///< of its battery; 0 = it does not measure
  int most_ticks_per_s = 20'000;  ///< beyond it a wheel gets no faster
};

/// A home-made base as its line shows it: an ideal pair of wheels, watchdog, bumpers, emergency
/// stop. What the floor makes of its motion is the world's.
class TextBoard final : public Emulator {
 public:
  /// @param touch  flags of bumpers, emergency stop and fault; empty = none, ever.
  explicit TextBoard(const TextBoardOptions& options = {}, std::function<unsigned()> touch = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The reset button: its counters begin at 0 again.
  void reset(Utime now);
  double left_ticks() const { return left_.travelled; }  ///< signed, since power-on
  double right_ticks() const { return right_.travelled; }
  double left_ticks_per_s() const { return left_.speed; }
  double right_ticks_per_s() const { return right_.speed; }

 private:
  struct Wheel {
    double goal = 0.0;
    double speed = 0.0;
    double travelled = 0.0;
    double counted_from = 0.0;
  };

  void run_until(Utime now);
  void turn_wheels(double dt_s);
  void on_line(const std::string& line, Utime now);
  void obey(const HostLine& line, Utime now);
  bool within(int value, int least, int most, Utime now);
  void say(const BoardLine& line, Utime now);
  unsigned flags() const;

  TextBoardOptions options_;
  std::function<unsigned()> touch_;
  LineCutter cutter_{kMaxLine};
  PacedOutput output_{kBaud};
  bool on_ = false;
  bool greeted_ = false;
  Utime ready_;
  Utime now_;  ///< up to which everything has happened
  Wheel left_, right_;
  bool motors_on_ = false, watchdog_stopped_ = false, has_sums_ = false;
  int watchdog_ms_ = 500, report_ms_ = 0;
  Utime last_motion_, next_report_, next_battery_;
};

}  // namespace marco::drivers::textbase
