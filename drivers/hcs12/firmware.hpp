#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hcs12/codec.hpp"
#include "drivers/transport/emulator.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::hcs12 {

inline constexpr int kAccumulatorMax = 255;  ///< of the PI loops
inline constexpr int kPwmMax = 255;

/// What both boards do alike: a line buffer of one line, replies sent by busy waiting (no tick is
/// worked off meanwhile), and a tick of 1.024 ms.
class FirmwareBoard : public Emulator {
 public:
  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  /// A closed line changes nothing on the board; its bytes are lost.
  void on_connection(bool connected, Utime now) override;

  /// The reset button, or power: RAM defaults, motors stopped, the banner.
  void reset(Utime now);

  int64_t lost_lines() const { return lost_lines_; }
  int64_t skipped_ticks() const { return skipped_ticks_; }

 protected:
  virtual void restart() = 0;        ///< RAM defaults; prints the banner
  virtual void physics_tick() = 0;   ///< 1.024 ms of the world, always
  virtual void firmware_tick() = 0;  ///< the interrupt, unless printing
  virtual void main_loop() = 0;      ///< what it checks after each tick
  virtual void execute(const Command& command) = 0;
  virtual bool takes_commands() const { return true; }

  void print(std::string_view text);
  Utime time() const { return time_; }

 private:
  void run_until(Utime now);
  void start(Utime now);
  bool printing(Utime at) const { return at < printing_until_; }
  void run_pending();

  bool started_ = false;
  bool connected_ = false;
  Utime time_;  ///< up to which everything has happened
  Utime next_tick_;
  Utime printing_until_;
  LineCutter cutter_;
  std::optional<Command> pending_;
  struct SentByte {
    Utime leaves;
    uint8_t byte;
  };
  std::deque<SentByte> sent_;
  int64_t lost_lines_ = 0;
  int64_t skipped_ticks_ = 0;
};

}  // namespace marco::drivers::hcs12
