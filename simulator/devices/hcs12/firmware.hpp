#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hcs12/codec.hpp"
#include "lcm_tools/base/utime.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::hcs12 {

inline constexpr int kPwmMax = 255;

struct MotorModel {
  double gain = 0.4;  ///< clicks a tick per step of PWM, settled
  double time_constant_ticks = 12.0;
  bool ideal = false;  ///< turns at exactly the desired speed, as in the timelines of the tests
};

/// A motor with its encoder, as both boards drive it.
struct Motor {
  MotorModel model;
  double position = 0.0;  ///< true, clicks, signed
  double speed = 0.0;     ///< true, clicks a tick, signed
  double travel = 0.0;    ///< magnitude
  int64_t counted = 0;    ///< travel already taken by the accumulator
  bool on = false;
  int direction = 1;
  int desired = 0;
  int pwm = 0;
  int speed_read = 0;
  int64_t total = 0;  ///< clicks counted since the start

  void turn();          ///< one tick of physics
  void read_counter();  ///< sets speed_read; the accumulator saturates at 255
  void start(int new_direction, int new_desired);
  void stop(int idle_pwm);
};

/// `w`: the board answers when its timer has run out or when all conditions it was ordered to check
/// hold.
class WaitCommand {
 public:
  /// Flags count only when there is one for each condition: the manual's example gives too few.
  void arm(const Command& command, std::size_t conditions);
  void clear() { armed_ = false; }
  bool armed() const { return armed_; }
  void tick() { ticks_ -= armed_ ? 1 : 0; }
  bool over(const std::vector<bool>& conditions) const;

 private:
  bool armed_ = false;
  int64_t ticks_ = 0;
  std::vector<bool> flags_;
};

/// What both boards do alike: a line buffer of one line, replies sent by busy waiting (the firmware
/// misses the ticks meanwhile), a tick of 1.024 ms, and the command `w`.
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
  /// What `w` can wait for, in the order of its flags.
  virtual std::vector<bool> wait_conditions() const = 0;

  void print(const std::string& text);
  void echo(const Command& command) { print({command.letter, '\n'}); }
  void arm_wait(const Command& command) { wait_.arm(command, wait_conditions().size()); }
  Utime time() const { return time_; }

 private:
  void run_until(Utime now);
  void start(Utime now);
  bool printing(Utime at) const { return at < printing_until_; }
  void run_pending();

  bool started_ = false;
  bool connected_ = false;
  bool readable_ = true;  ///< the client listens at our speed
  Utime time_;            ///< up to which everything has happened
  Utime next_tick_;
  Utime printing_until_;
  LineCutter cutter_;
  std::optional<Command> pending_;
  WaitCommand wait_;
  struct SentByte {
    Utime leaves;
    uint8_t byte;
  };
  std::deque<SentByte> sent_;
  int64_t lost_lines_ = 0;
  int64_t skipped_ticks_ = 0;
};

}  // namespace marco::drivers::hcs12
