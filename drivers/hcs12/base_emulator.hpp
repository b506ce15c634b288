#pragma once

#include <array>
#include <functional>
#include <vector>

#include "drivers/hcs12/firmware.hpp"

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
  bool ideal_wheels = false;  ///< exactly the desired speed, as in the timelines of the tests
  double left_gain = 0.400;   ///< clicks a tick per step of PWM, settled
  double right_gain = 0.388;
  double wheel_time_constant_ticks = 12.0;
  double speed_of_sound_m_per_s = 343.0;
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

 private:
  struct Wheel {
    double gain = 0.0;
    double position = 0.0;  ///< true, signed
    double speed = 0.0;     ///< true, clicks a tick, signed
    int64_t counted = 0;    ///< magnitude of travel already taken by the accumulator
    double travel = 0.0;    ///< magnitude
    bool on = false;
    bool ahead = true;
    int desired = 0;
    int pwm = 0;
    int speed_read = 0;
    int64_t total = 0;
  };
  struct Wait {
    bool armed = false;
    int64_t ticks = 0;
    bool flags = false, left = false, right = false, sonar = false;
  };

  void set_params(uint32_t tenths, int left_sign, int right_sign);
  void set_velocity(int left, int right);
  void stop_motors();
  void speed_control();
  void ac_control();
  void sonar_tick();
  void read_shot();
  void sonar_command(const Command& command);
  void arm_wait(const Command& command);
  void print_help();
  void turn_wheel(Wheel& wheel) const;
  static int read_counter(Wheel& wheel);

  BaseWorld world_;
  BaseEmulatorOptions options_;
  Wheel left_, right_;
  int64_t ticks_ = 0;
  Ramp ramp_;
  int64_t target_ = 0;
  int64_t brake_point_ = 0;
  int64_t integral_ = 0;
  int bias_ = 0;
  uint32_t ramp_timer_ = 0;
  bool accelerating_ = false;
  bool braking_ = false;
  bool buzzer_ = false;
  Wait wait_;
  std::vector<uint32_t> order_;
  std::array<uint32_t, 16> readings_{};
  bool sonar_on_ = false;
  std::size_t shot_ = 0;
  uint32_t shot_tick_ = 0;
  uint32_t listen_ms_ = 50;
  uint32_t rest_ms_ = 20;
  int64_t rounds_ = 0;
  int64_t shots_left_ = 0;  ///< of the countdown that `w` looks at
};

}  // namespace marco::drivers::hcs12
