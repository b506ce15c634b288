#include "teleop/operator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/order_age.hpp"

namespace marco::teleop {
namespace {

constexpr double kHeadEveryS = 0.5;  // of the gamepad's stick: the board wants its moves one by one
constexpr double kAheadRad = 0.02;
constexpr double kEngageEveryS = 0.5;  // for a base that was started meanwhile

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
  const bool goes_on = driving_ && velocity == velocity_ && rate == rate_;
  velocity_ = velocity;
  rate_ = rate;
  driving_ = true;
  hand_ = hand;
  drive_until_ = until;
  if (!goes_on) last_sent_ = {};  // at once
}

void Operator::emergency(char key, Utime now) {
  EmergencyStop message{now, key == 'e', "marco drive", ""};
  engaged_.reset();
  if (message.engaged) engaged_ = message;
  last_engaged_ = now;
  // A datagram may be lost; the same message again changes nothing.
  orders_.emergency.assign(3, message);
}

void Operator::on_emergency_stop(const EmergencyStop& stop) {
  if (!stop.engaged) engaged_.reset();
}

bool Operator::step_key(char key, Utime now) {
  BaseCommand command;
  command.kind = key == 'i' || key == 'k' ? BaseCommand::Kind::move : BaseCommand::Kind::turn;
  command.distance_m = key == 'k' ? -options_.step_m : options_.step_m;
  command.angle_rad = deg_to_rad(key == 'l' ? -options_.step_deg : options_.step_deg);
  if (std::string("ikjl").find(key) == std::string::npos) return false;
  driving_ = false;
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
      emergency(key, now);
      break;
    case 'q':
      quit_ = true;
      break;
    default:
      if (step_key(key, now) || head_key(key, now)) return;
  }
  // Space, q, the emergency's keys and whatever was hit in fright.
  const Orders halt = stop(now);
  orders_.base.insert(orders_.base.end(), halt.base.begin(), halt.base.end());
  orders_.pantilt.insert(orders_.pantilt.end(), halt.pantilt.begin(), halt.pantilt.end());
  orders_.emergency.insert(orders_.emergency.end(), halt.emergency.begin(), halt.emergency.end());
}

double Operator::axis(const GamepadState& state, std::size_t number) const {
  if (number >= state.axes.size()) return 0.0;
  const auto value = static_cast<double>(state.axes[number]);
  return std::abs(value) < options_.gamepad_dead_zone ? 0.0 : value;
}

void Operator::on_gamepad(const GamepadState& state, Utime now) {
  const bool stop_button = state.buttons.size() > 1 && state.buttons[1];
  if (!state.connected || stop_button) {
    const Orders halt = stop(now);
    orders_.base.insert(orders_.base.end(), halt.base.begin(), halt.base.end());
    orders_.emergency.insert(orders_.emergency.end(), halt.emergency.begin(), halt.emergency.end());
    return;
  }
  gamepad_trouble_ = why_stale(state.utime, now);
  if (!gamepad_trouble_.empty()) return;
  const Utime until = now + Duration::from_seconds(kOrderHoldsS);
  const double velocity = -axis(state, 1), rate = -axis(state, 0);  // up and left are negative
  if (velocity != 0.0 || rate != 0.0) {
    drive(velocity, rate, Hand::gamepad, until);
  } else if (driving_ && hand_ == Hand::gamepad) {
    drive_until_ = now;
  }
  head_pan_ = -axis(state, 2);
  head_tilt_ = -axis(state, 3);
  head_until_ = until;
}

Operator::Orders Operator::stop(Utime now) {
  driving_ = false;
  head_pan_ = head_tilt_ = 0.0;
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
  if (driving_ && now >= drive_until_) {
    driving_ = false;
    order(BaseCommand{}, now);
  }
  if (driving_ && (now - last_sent_).seconds() >= 1.0 / options_.send_hz) {
    last_sent_ = now;
    BaseCommand command;
    command.kind = BaseCommand::Kind::velocity;
    command.velocity_m_per_s = velocity_ * factor_ * options_.velocity_m_per_s;
    command.yaw_rate_rad_per_s = rate_ * factor_ * deg_to_rad(options_.yaw_rate_deg_per_s);
    order(command, now);
  }
  if (now >= head_until_) head_pan_ = head_tilt_ = 0.0;
  if (engaged_ && (now - last_engaged_).seconds() >= kEngageEveryS) {
    last_engaged_ = now;
    orders_.emergency.push_back(*engaged_);
  }
  if ((head_pan_ != 0.0 || head_tilt_ != 0.0) && (now - last_head_).seconds() >= kHeadEveryS) {
    last_head_ = now;
    turn_head(head_pan_ * options_.gaze_step_deg, head_tilt_ * options_.gaze_step_deg, now);
  }
  if (head_ && !std::exchange(looked_, true) && options_.look_ahead_at_start) {
    const bool ahead =
        std::abs(head_->pan_rad) < kAheadRad && std::abs(head_->tilt_rad) < kAheadRad;
    if (!ahead && orders_.pantilt.empty()) look(0.0, 0.0, now);
  }
  return std::exchange(orders_, {});
}

}  // namespace marco::teleop
