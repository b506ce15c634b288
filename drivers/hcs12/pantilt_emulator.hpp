#pragma once

#include "drivers/hcs12/firmware.hpp"

namespace marco::drivers::hcs12 {

struct PanTiltEmulatorOptions {
  bool listing_status = true;  ///< nine fields; else the manual's four
  bool listing_stop = true;    ///< `p` is not dispatched: no reply, no stop
  int pan_limit_units = 248;   ///< of the build: 250, 248 (ROBOT1) or 244
  int tilt_limit_units = 100;
  bool ideal_wheels = false;
  double gain = 0.4;  ///< clicks a tick per step of PWM, settled
  double time_constant_ticks = 12.0;
  double pan_at_power_on_units = 3.4;  ///< where it was left
  double tilt_at_power_on_units = 2.6;
};

/// The pan-tilt board as its listing behaves: homing, ramps that end on an index pulse of the
/// motor, end switches.
class PanTiltEmulator : public FirmwareBoard {
 public:
  explicit PanTiltEmulator(const PanTiltEmulatorOptions& options);

  /// True place of the drives in turns of the motor from their homes, and turns a second.
  double pan_units() const { return pan_.position / kClicksPerUnit; }
  double tilt_units() const { return tilt_.position / kClicksPerUnit; }
  double pan_units_per_s() const { return rate(pan_); }
  double tilt_units_per_s() const { return rate(tilt_); }
  bool homed() const { return homing_ == Homing::done; }

  static constexpr double kClicksPerUnit = 1000.0;

 protected:
  void restart() override;
  void physics_tick() override;
  void firmware_tick() override;
  void main_loop() override;
  void execute(const Command& command) override;
  bool takes_commands() const override { return homed(); }

 private:
  enum class Homing { right, leave_right, pan_index, down, leave_low, tilt_index, done };
  struct Axis {
    double position = 0.0;  ///< true, clicks
    double speed = 0.0;
    double travel = 0.0;
    int64_t counted = 0;
    bool index_passed = false;
    bool on = false;
    int direction = 1;
    int desired = 0;
    int pwm = 0;
    int speed_read = 0;
    int units = 0;
    int64_t since_index = 0;  ///< signed
    int64_t min_gap = 250;
    int64_t total = 0;
    int64_t target = 0;
    int64_t brake_point = 0;
    int turns_left = 0;  ///< index pulses to go; 0 = runs freely (homing)
    Ramp ramp{3, 50, 30};
    uint32_t timer = 0;
    bool accelerating = false;
    bool braking = false;
    bool indexed = false;  ///< a pulse counted in the last tick
  };

  static double rate(const Axis& axis);
  void turn(Axis& axis) const;
  void control(Axis& axis) const;
  static void count(Axis& axis);
  static void ramp_control(Axis& axis);
  static void stop(Axis& axis);
  static void run(Axis& axis, int direction, int speed);
  void go_to(Axis& axis, int unit, bool lower_stop, bool upper_stop);
  void homing_step();
  bool right_stop() const { return pan_.position <= -kStopClicks; }
  bool left_stop() const {
    return pan_.position >= (options_.pan_limit_units + 1) * kClicksPerUnit;
  }
  bool low_stop() const { return tilt_.position <= -kStopClicks; }

  static constexpr double kStopClicks = 400.0;  ///< the lower switches sit so far before the home

  PanTiltEmulatorOptions options_;
  Axis pan_, tilt_;
  Homing homing_ = Homing::right;
  bool wait_armed_ = false;
  int64_t wait_ticks_ = 0;
  bool wait_pan_ = false, wait_tilt_ = false;
};

}  // namespace marco::drivers::hcs12
