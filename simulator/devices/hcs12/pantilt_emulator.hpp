#pragma once

#include "drivers/hcs12/ramp.hpp"
#include "simulator/devices/hcs12/firmware.hpp"

namespace marco::drivers::hcs12 {

struct PanTiltEmulatorOptions {
  bool listing_status = true;  ///< nine fields; else the manual's four
  bool listing_stop = true;    ///< `p` is not dispatched: no reply, no stop
  int pan_limit_units = 248;   ///< of the build: 250, 248 (ROBOT1) or 244
  int tilt_limit_units = 100;
  bool ideal_wheels = false;           ///< see MotorModel
  double pan_at_power_on_units = 3.4;  ///< where it was left
  double tilt_at_power_on_units = 2.6;
};

/// The pan-tilt board as its listing behaves: homing, ramps that end on an index pulse of the
/// motor, end switches.
class PanTiltEmulator : public FirmwareBoard {
 public:
  explicit PanTiltEmulator(const PanTiltEmulatorOptions& options);

  /// True position of the drives in turns of the motor from their homes.
  double pan_units() const { return pan_.position / kClicksPerUnit; }
  double tilt_units() const { return tilt_.position / kClicksPerUnit; }
  bool homed() const { return homing_ == Homing::done; }

  static constexpr double kClicksPerUnit = 1000.0;

 protected:
  void restart() override;
  void physics_tick() override;
  void firmware_tick() override;
  void main_loop() override;
  void execute(const Command& command) override;
  bool takes_commands() const override { return homed(); }
  std::vector<bool> wait_conditions() const override { return {!pan_.on, !tilt_.on}; }

 private:
  enum class Homing { right, leave_right, pan_index, down, leave_low, tilt_index, done };
  struct Axis : Motor {
    void turn();   ///< one tick of physics
    void count();  ///< the firmware's counters
    void control();
    void follow_ramp();
    void stop();
    void seek(int new_direction, int new_desired);
    void go_to(int unit, bool lower_stop, bool upper_stop);

    bool index_passed = false;
    bool indexed = false;  ///< a pulse counted in the last tick
    int units = 0;
    int64_t since_index = 0;  ///< signed
    int64_t min_gap = 250;
    int turns_left = 0;  ///< index pulses to go; 0 = runs freely (homing)
    RampControl control_ramp;
  };

  void homing_step();
  std::string status() const;
  bool right_stop() const { return pan_.position <= -kStopClicks; }
  bool left_stop() const {
    return pan_.position >= (options_.pan_limit_units + 1) * kClicksPerUnit;
  }
  bool low_stop() const { return tilt_.position <= -kStopClicks; }

  static constexpr double kStopClicks = 400.0;  ///< the lower switches sit so far before the home

  PanTiltEmulatorOptions options_;
  Axis pan_, tilt_;
  Homing homing_ = Homing::right;
};

}  // namespace marco::drivers::hcs12
