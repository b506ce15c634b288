#pragma once

#include <functional>
#include <optional>
#include <random>

#include "drivers/create/codec.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/lagging_wheel.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::create {

struct CreateEmulatorOptions {
  int baud = kBaud;
  double lag_s = 0.03;      ///< time constant of its wheels
  double boot_s = 1.0;      ///< from a reset until it listens
  int millivolts = 15'000;  ///< of its battery
  int mode_offset = 0;      ///< 1: firmware that reports its mode one too high
};

/// What touches the robot.
struct CreateWorld {
  bool left_bump = false, right_bump = false;
  bool left_drop = false, right_drop = false;
  bool cliff = false;
  bool on_charger = false;
};

/// A Create 2 as its line shows it: modes, streams, wheel speeds that it holds without end,
/// counters that wrap and take their sign from the order. A cliff, a hanging wheel or a charger
/// ends its mode "safe" and stops it. At another speed it receives nothing, and a client reads
/// garbage.
class CreateEmulator final : public Emulator {
 public:
  explicit CreateEmulator(const CreateEmulatorOptions& options = {},
                          std::function<CreateWorld()> world = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The battery was taken out and put back: it is off, and its counters begin at 0.
  void reset(Utime now);
  /// It falls asleep, as after five minutes without a host: receives nothing until CLEAN is
  /// pressed.
  void sleep() { asleep_ = true; }
  void press_clean() { asleep_ = false; }
  OiMode mode() const { return mode_; }
  double left_m() const { return left_.travelled_m; }  ///< signed, since it was made
  double right_m() const { return right_.travelled_m; }
  double left_m_per_s() const { return left_.speed_m_per_s; }
  double right_m_per_s() const { return right_.speed_m_per_s; }

 private:
  void run_until(Utime now);
  void step(double dt_s);
  void obey(const Request& request);
  void stop_wheels() { left_.goal_m_per_s = right_.goal_m_per_s = 0.0; }
  CreateWorld world() const { return world_ ? world_() : CreateWorld{}; }
  Sensors sensors() const;

  CreateEmulatorOptions options_;
  std::function<CreateWorld()> world_;
  RequestParser parser_;
  PacedOutput output_;
  std::mt19937 noise_{1};  ///< what a client at another speed reads
  bool readable_ = true;
  bool started_ = false;  ///< its time runs
  bool asleep_ = false;
  bool streams_ = false;
  Bytes streamed_;  ///< packets of a frame
  OiMode mode_ = OiMode::off;
  Utime ready_, now_, next_frame_;
  LaggingWheel left_, right_;
};

}  // namespace marco::drivers::create
