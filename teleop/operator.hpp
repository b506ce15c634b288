#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/process/emergency_stop_sender.hpp"
#include "teleop/terminal.hpp"

namespace marco::teleop {

struct OperatorOptions {
  double velocity_m_per_s = 0.25;
  double yaw_rate_deg_per_s = 25.0;
  double step_m = 0.25;  ///< of the keys that go by steps
  double step_deg = 10.0;
  double gaze_step_deg = 5.0;
  double key_holds_s = 0.6;  ///< a terminal repeats a held key after about half a second
  double send_hz = 10.0;
  double gamepad_dead_zone = 0.15;
  /// A laser on the head draws the map only when it is level, which a pan-tilt's home may not be.
  bool look_ahead_at_start = true;

  template <class Visitor>
  void visit(Visitor& v) {
    v("velocity_m_per_s", velocity_m_per_s, kPositive);
    v("yaw_rate_deg_per_s", yaw_rate_deg_per_s, kPositive);
    v("step_m", step_m, kPositive);
    v("step_deg", step_deg, kPositive);
    v("gaze_step_deg", gaze_step_deg, kPositive);
    v("key_holds_s", key_holds_s, kPositive);
    v("send_hz", send_hz, Limits{2.5, 50.0});
    v("gamepad_dead_zone", gamepad_dead_zone, Limits{0.0, 0.9});
    v("look_ahead_at_start", look_ahead_at_start);
  }
};

/// Turns keys and gamepad into orders to the robot. Without clock and network.
///
/// Keys: arrows drive while held (or until another key), i k j l go by steps, t g f h turn the
/// pan-tilt, r looks ahead, + and - change the speed, space stops everything, e engages the
/// emergency stop and c clears it, q ends.
/// Gamepad: first stick drives, second turns the pan-tilt, button 1 stops. Its state must come
/// again within kOrderHoldsS, else its sticks are at rest.
class Operator {
 public:
  explicit Operator(const OperatorOptions& options);

  void on_key(char key, Utime now);
  void on_gamepad(const GamepadState& state, Utime now);
  void on_pantilt(const PanTiltState& state) { head_ = state; }
  /// Anybody's: what was released is not engaged again from here.
  void on_emergency_stop(const process::EmergencyStopSender::Message& stop) {
    emergency_.hear(stop);
  }

  struct Orders {
    std::vector<BaseCommand> base;
    std::vector<PanTiltCommand> pantilt;
    std::vector<process::EmergencyStopSender::Message> emergency;
  };
  /// Call often. @returns what is to be sent now.
  Orders step(Utime now);
  /// What stops everything.
  Orders stop(Utime now);

  bool wants_to_quit() const { return quit_; }
  double speed_factor() const { return factor_; }
  /// Why the gamepad is not obeyed; "" = it is, or there is none.
  const std::string& gamepad_trouble() const { return gamepad_trouble_; }

 private:
  void order(BaseCommand command, Utime now);
  void look(double pan_rad, double tilt_rad, Utime now);
  void turn_head(double pan_deg, double tilt_deg, Utime now);
  enum class Hand { key, gamepad };
  void drive(double velocity, double rate, Hand hand, Utime until);
  void order_emergency(char key, Utime now);
  bool step_key(char key, Utime now);
  bool head_key(char key, Utime now);
  double axis(const GamepadState& state, std::size_t number) const;

  OperatorOptions options_;
  struct Drive {
    double velocity = 0.0;  ///< parts of the full speed, -1..1
    double rate = 0.0;
    bool active = false;
    Hand hand = Hand::key;
    Utime until;
    Utime last_sent;
  };
  struct HeadStick {  ///< the gamepad's second stick
    double pan = 0.0;
    double tilt = 0.0;
    Utime until;
    Utime last_sent;
  };
  double factor_ = 1.0;
  Drive drive_;
  HeadStick stick_;
  std::optional<PanTiltState> head_;
  bool looked_ = false;  ///< ahead, at the start
  std::string gamepad_trouble_;
  process::EmergencyStopSender emergency_{"marco drive"};
  Orders orders_;
  int64_t id_ = 0;
  bool quit_ = false;
};

}  // namespace marco::teleop
