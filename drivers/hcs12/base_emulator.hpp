#pragma once

#include <array>
#include <functional>

#include "drivers/hcs12/firmware.hpp"
#include "drivers/hcs12/ramp.hpp"
#include "drivers/hcs12/sonar_sequencer.hpp"

namespace marco::drivers::hcs12 {

/// What the board's plugs are connected to.
struct BaseWorld {
  /// Range of a transducer, 0 ahead and counter-clockwise from there; infinity = no echo.
  std::function<double(std::size_t transducer)> sonar_range_m;
  /// Of the four batteries; none given = fresh ones.
  std::function<std::array<double, 4>()> battery_v;
};

struct BaseEmulatorOptions {
  SonarForm sonar_form = SonarForm::line_each;  ///< the listing's
  bool ideal_wheels = false;                    ///< see MotorModel
  double left_gain = 0.400;
  double right_gain = 0.388;
};

/// The base board as its listing behaves: PI loop, ramps, stop rule, sonar timing, counters that
/// saturate while it prints. The brake holds at once: behind a gear of 65.5:1 no wheel runs on by a
/// click.
class BaseEmulator : public FirmwareBoard {
 public:
  BaseEmulator(BaseWorld world, const BaseEmulatorOptions& options);

  /// True travel since power-on, signed, ahead > 0. What the wheels did, not what was counted.
  double left_clicks() const { return left_.position; }
  double right_clicks() const { return right_.position; }
  bool motors_on() const { return left_.on || right_.on; }
  bool buzzer() const { return buzzer_; }
  int64_t ticks() const { return ticks_; }

 protected:
  void restart() override;
  void physics_tick() override;
  void firmware_tick() override;
  void main_loop() override;
  void execute(const Command& command) override;
  std::vector<bool> wait_conditions() const override {
    return {!left_.on, !right_.on, sonar_.shots_left() <= 0};
  }

 private:
  void start_run(int64_t clicks, const WheelSigns& signs);
  void set_velocity(int left, int right);
  void stop_motors();
  void speed_control();
  void follow_ramp();
  std::string wheel_status() const;
  std::string batteries() const;

  std::function<std::array<double, 4>()> battery_v_;
  Motor left_, right_;
  int64_t ticks_ = 0;
  RampControl ramp_;
  int64_t target_ = 0;  ///< clicks of each wheel, 0 = none
  int64_t integral_ = 0;
  int bias_ = 0;
  bool buzzer_ = false;
  SonarSequencer sonar_;
};

}  // namespace marco::drivers::hcs12
