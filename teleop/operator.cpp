#include "teleop/operator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/order_age.hpp"

namespace marco::teleop {
namespace {

constexpr double kHeadEveryS = 0.5;  // of the gamepad's stick: the board wants its moves one by one
constexpr double kAheadRad = 0.02;

}  // namespace

Operator::Operator(const OperatorOptions& options) : options_(options) {
  validate(options, "operator");
}

void Operator::order(BaseCommand command, Utime now) {
  command.utime = now;
  // Another operator or a tour may count too: ids go by time.
  id_ = std::max(id_ + 1, now.us / 1000);
  command.id = id_;
  orders_.base.push_back(command);
}

void Operator::look(double pan_rad, double tilt_rad, Utime now) {
  PanTiltCommand command;
  command.utime = now;
  command.kind = PanTiltCommand::Kind::go_to;
  command.pan_rad = normalize_angle(pan_rad);
  command.tilt_rad = tilt_rad;
  orders_.pantilt.push_back(command);
}

void Operator::turn_head(double pan_deg, double tilt_deg, Utime now) {
  if (!head_) return;
  look(head_->pan_rad + deg_to_rad(pan_deg), head_->tilt_rad + deg_to_rad(tilt_deg), now);
}

void Operator::drive(double velocity, double rate, Hand hand, Utime until) {
  const bool unchanged = drive_.active && velocity == drive_.velocity && rate == drive_.rate;
  // A change is sent at once.
  drive_ = {velocity, rate, true, hand, until, unchanged ? drive_.last_sent : Utime{}};
}

void Operator::order_emergency(char key, Utime now) {
  const auto what = key == 'e' ? process::EmergencyStop::engage : process::EmergencyStop::release;
  orders_.emergency.assign(3, emergency_.order(what, "", now.us, now.us));
}

bool Operator::step_key(char key, Utime now) {
  BaseCommand command;
  command.kind = key == 'i' || key == 'k' ? BaseCommand::Kind::move : BaseCommand::Kind::turn;
  command.distance_m = key == 'k' ? -options_.step_m : options_.step_m;
  command.angle_rad = deg_to_rad(key == 'l' ? -options_.step_deg : options_.step_deg);
  if (std::string("ikjl").find(key) == std::string::npos) return false;
  drive_.active = false;
  order(command, now);
  return true;
}

bool Operator::head_key(char key, Utime now) {
  const double step = options_.gaze_step_deg;
  switch (key) {
    case 't':
      turn_head(0.0, step, now);
      return true;
    case 'g':
      turn_head(0.0, -step, now);
      return true;
    case 'f':
      turn_head(step, 0.0, now);
      return true;
    case 'h':
      turn_head(-step, 0.0, now);
      return true;
    case 'r':
      look(0.0, 0.0, now);
      return true;
    default:
      return false;
  }
}

void Operator::on_key(char key, Utime now) {
  const Utime until = now + Duration::from_seconds(options_.key_holds_s);
  switch (key) {
    case Keyboard::kUp:
      return drive(1.0, 0.0, Hand::key, until);
    case Keyboard::kDown:
      return drive(-1.0, 0.0, Hand::key, until);
    case Keyboard::kLeft:
      return drive(0.0, 1.0, Hand::key, until);
    case Keyboard::kRight:
      return drive(0.0, -1.0, Hand::key, until);
    case '+':
      factor_ = std::min(4.0, factor_ * 1.25);
      return;
    case '-':
      factor_ = std::max(0.2, factor_ / 1.25);
      return;
    case 'e':
    case 'c':
      order_emergency(key, now);
      break;
    case 'q':
      quit_ = true;
      break;
    default:
      if (step_key(key, now) || head_key(key, now)) return;
  }
  orders_ = stop(now);  // space, q, the emergency stop's keys, and any key hit in a panic
}

double Operator::axis(const GamepadState& state, std::size_t number) const {
  if (number >= state.axes.size()) return 0.0;
  const auto value = static_cast<double>(state.axes[number]);
  return std::abs(value) < options_.gamepad_dead_zone ? 0.0 : value;
}

void Operator::on_gamepad(const GamepadState& state, Utime now) {
  const bool stop_button = state.buttons.size() > 1 && state.buttons[1];
  if (!state.connected || stop_button) {
    orders_ = stop(now);
    orders_.pantilt.clear();
    return;
  }
  gamepad_trouble_ = why_stale(state.utime, now);
  if (!gamepad_trouble_.empty()) return;
  const Utime until = now + Duration::from_seconds(kOrderHoldsS);
  const double velocity = -axis(state, 1), rate = -axis(state, 0);  // up and left are negative
  if (velocity != 0.0 || rate != 0.0) {
    drive(velocity, rate, Hand::gamepad, until);
  } else if (drive_.active && drive_.hand == Hand::gamepad) {
    drive_.until = now;
  }
  stick_.pan = -axis(state, 2);
  stick_.tilt = -axis(state, 3);
  stick_.until = until;
}

Operator::Orders Operator::stop(Utime now) {
  drive_.active = false;
  stick_.pan = stick_.tilt = 0.0;
  Orders halt;
  halt.emergency = std::exchange(orders_, {}).emergency;
  order(BaseCommand{}, now);
  halt.base = std::exchange(orders_, {}).base;
  PanTiltCommand head;
  head.utime = now;
  halt.pantilt.push_back(head);
  return halt;  // what else was ordered and not yet sent is forgotten
}

Operator::Orders Operator::step(Utime now) {
  if (drive_.active && now >= drive_.until) {
    drive_.active = false;
    order(BaseCommand{}, now);
  }
  if (drive_.active && (now - drive_.last_sent).seconds() >= 1.0 / options_.send_hz) {
    drive_.last_sent = now;
    BaseCommand command;
    command.kind = BaseCommand::Kind::velocity;
    command.velocity_m_per_s = drive_.velocity * factor_ * options_.velocity_m_per_s;
    command.yaw_rate_rad_per_s = drive_.rate * factor_ * deg_to_rad(options_.yaw_rate_deg_per_s);
    order(command, now);
  }
  if (now >= stick_.until) stick_.pan = stick_.tilt = 0.0;
  if (const auto stop = emergency_.due(now.us)) orders_.emergency.push_back(*stop);
  if ((stick_.pan != 0.0 || stick_.tilt != 0.0) &&
      (now - stick_.last_sent).seconds() >= kHeadEveryS) {
    stick_.last_sent = now;
    turn_head(stick_.pan * options_.gaze_step_deg, stick_.tilt * options_.gaze_step_deg, now);
  }
  if (head_ && !std::exchange(looked_, true) && options_.look_ahead_at_start) {
    const bool ahead =
        std::abs(head_->pan_rad) < kAheadRad && std::abs(head_->tilt_rad) < kAheadRad;
    if (!ahead && orders_.pantilt.empty()) look(0.0, 0.0, now);
  }
  return std::exchange(orders_, {});
}

}  // namespace marco::teleop
