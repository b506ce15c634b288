#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "drivers/hcs12/codec.hpp"
#include "drivers/hcs12/ramp.hpp"
#include "simulator/devices/hcs12/firmware.hpp"

namespace marco::drivers::hcs12 {

/// The sonars of the emulated base board: they fire one after the other in a settable order. A shot
/// is fired, its echo is listened for, the ring rests, and the next one fires.
class SonarSequencer {
 public:
  struct Options {
    SonarForm form = SonarForm::line_each;  ///< the listing's
    double speed_of_sound_m_per_s = 343.0;
  };
  using Range = std::function<double(std::size_t transducer)>;  ///< [m]; infinity = no echo

  SonarSequencer(Range range_m, const Options& options);

  void restart();
  void tick();
  /// `S`. Transducers in the order in which they fire.
  void set_order(const Command& command);
  /// `s`. @returns the reply.
  std::string execute(const Command& command);
  bool on() const { return on_; }
  /// Of the countdown that `w` and `q` look at.
  int64_t shots_left() const { return shots_left_; }

 private:
  void take_reading();

  Range range_m_;
  Options options_;
  std::vector<uint32_t> order_;
  std::array<uint32_t, 16> readings_{};
  bool on_ = false;
  std::size_t shot_ = 0;
  uint32_t shot_tick_ = 0;
  uint32_t listen_ms_ = 50;
  uint32_t rest_ms_ = 20;
  int64_t rounds_ = 0;
  int64_t shots_left_ = 0;
};

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
