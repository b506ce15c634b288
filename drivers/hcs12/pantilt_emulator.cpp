#include "drivers/hcs12/pantilt_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

constexpr int kSeekSpeed = 10;
constexpr int kLeaveSpeed = 2;

}  // namespace

PanTiltEmulator::PanTiltEmulator(const PanTiltEmulatorOptions& options) : options_(options) {
  pan_.position = options.pan_at_power_on_units * kClicksPerUnit;
  tilt_.position = options.tilt_at_power_on_units * kClicksPerUnit;
  tilt_.min_gap = 251;
}

double PanTiltEmulator::rate(const Axis& axis) {
  return axis.speed / kClicksPerUnit / (kTickUs * 1e-6);
}

void PanTiltEmulator::restart() {
  for (Axis* axis : {&pan_, &tilt_}) {
    stop(*axis);
    axis->ramp = Ramp{3, 50, 30};
    axis->units = 0;
    axis->since_index = 0;
  }
  wait_armed_ = false;
  homing_ = Homing::right;
  run(pan_, -1, kSeekSpeed);
  print("Sistema ROCA-PANT-TILT v1.0\nGirando a la derecha\n");
}

void PanTiltEmulator::turn(Axis& axis) const {
  if (!axis.on) {
    axis.speed = 0.0;
    return;
  }
  const double wanted =
      axis.direction * (options_.ideal_wheels ? axis.desired : options_.gain * axis.pwm);
  const double follow =
      options_.ideal_wheels ? 1.0 : 1.0 - std::exp(-1.0 / options_.time_constant_ticks);
  axis.speed += follow * (wanted - axis.speed);
  const double before = std::floor(axis.position / kClicksPerUnit);
  axis.position += axis.speed;
  axis.travel += std::abs(axis.speed);
  // A pulse sits on each multiple; coming up it is met on reaching it, going down on leaving it.
  const double after = std::floor(axis.position / kClicksPerUnit);
  if (after != before) axis.index_passed = true;
}

void PanTiltEmulator::physics_tick() {
  turn(pan_);
  turn(tilt_);
}

void PanTiltEmulator::count(Axis& axis) {
  const auto passed = static_cast<int64_t>(std::floor(axis.travel + 1e-9)) - axis.counted;
  axis.counted += passed;
  axis.speed_read = static_cast<int>(std::min<int64_t>(passed, kAccumulatorMax));
  axis.indexed = false;
  if (!axis.on) {
    axis.index_passed = false;
    return;
  }
  axis.total += axis.speed_read;
  axis.since_index += axis.direction * axis.speed_read;
  if (!std::exchange(axis.index_passed, false)) return;
  if (std::abs(axis.since_index) < axis.min_gap) return;  // the same pulse again
  axis.units += axis.direction;
  axis.since_index = 0;
  axis.indexed = true;
  if (axis.turns_left > 0 && --axis.turns_left == 0) stop(axis);
}

void PanTiltEmulator::control(Axis& axis) const {
  if (!axis.on) return;
  axis.pwm = std::clamp(axis.pwm + (axis.desired - axis.speed_read), 0, kPwmMax);
}

void PanTiltEmulator::ramp_control(Axis& axis) {
  if (!axis.on || axis.turns_left == 0) return;
  if (!axis.braking && axis.total >= axis.brake_point) {
    axis.accelerating = false;
    axis.braking = true;
  }
  if (axis.timer > 0) {
    --axis.timer;
    return;
  }
  if (axis.accelerating) {
    if (axis.speed_read + 3 >= static_cast<int>(axis.ramp.top)) {
      axis.brake_point = axis.target - axis.total;
      axis.accelerating = false;
    }
    if (axis.desired < static_cast<int>(axis.ramp.top)) ++axis.desired;
  } else if (axis.braking && axis.desired > static_cast<int>(axis.ramp.start)) {
    --axis.desired;
  }
  axis.timer = axis.ramp.step_ticks;
}

void PanTiltEmulator::firmware_tick() {
  for (Axis* axis : {&pan_, &tilt_}) {
    count(*axis);
    control(*axis);
    ramp_control(*axis);
  }
  if (homed()) {
    if (pan_.direction > 0 ? left_stop() : right_stop()) stop(pan_);
    if (tilt_.direction < 0 && low_stop()) stop(tilt_);
  }
  if (wait_armed_) --wait_ticks_;
}

void PanTiltEmulator::main_loop() {
  if (!homed()) homing_step();
  if (!wait_armed_) return;
  const bool flagged = wait_pan_ || wait_tilt_;
  const bool still = (!wait_pan_ || !pan_.on) && (!wait_tilt_ || !tilt_.on);
  if (wait_ticks_ <= 0 || (flagged && still)) {
    wait_armed_ = false;
    print("w\n");
  }
}

void PanTiltEmulator::homing_step() {
  const auto next = [this](Homing homing, std::string_view text) {
    homing_ = homing;
    print(text);
  };
  switch (homing_) {
    case Homing::right:
      if (!right_stop()) return;
      run(pan_, 1, kLeaveSpeed);
      return next(Homing::leave_right, "Se alcanz\xF3 el tope derecho\nGirando a la izquierda\n");
    case Homing::leave_right:
      if (right_stop()) return;
      pan_.since_index = pan_.min_gap;
      return next(Homing::pan_index, "Se liber\xF3 el tope derecho\nGiro de 1 unidad\n");
    case Homing::pan_index:
      if (!pan_.indexed) return;
      stop(pan_);
      pan_.units = 0;
      run(tilt_, -1, kSeekSpeed);
      return next(Homing::down, "Motor de giro apagado\nHacia abajo\n");
    case Homing::down:
      if (!low_stop()) return;
      run(tilt_, 1, kLeaveSpeed);
      return next(Homing::leave_low, "Se alcanz\xF3 el tope inferior\nHacia arriba\n");
    case Homing::leave_low:
      if (low_stop()) return;
      tilt_.since_index = tilt_.min_gap;
      return next(Homing::tilt_index, "Se liber\xF3 el tope inferior\nHacia arriba 1 unidad\n");
    case Homing::tilt_index:
      if (!tilt_.indexed) return;
      stop(tilt_);
      tilt_.units = 0;
      return next(Homing::done, "Motor de inclinaci\xF3n apagado\nListo\n");
    case Homing::done:
      return;
  }
}

void PanTiltEmulator::stop(Axis& axis) {
  axis.on = false;
  axis.pwm = 0;
  axis.speed = 0.0;
  axis.turns_left = 0;
}

void PanTiltEmulator::run(Axis& axis, int direction, int speed) {
  axis.on = true;
  axis.direction = direction;
  axis.desired = speed;
  axis.pwm = 0;
  axis.turns_left = 0;
  axis.index_passed = false;
}

void PanTiltEmulator::go_to(Axis& axis, int unit, bool lower_stop, bool upper_stop) {
  const int turns = unit - axis.units;
  const int direction = turns < 0 ? -1 : 1;
  if (turns == 0) {
    stop(axis);
    return;
  }
  if (direction > 0 ? upper_stop : lower_stop) return;
  axis.on = true;
  axis.direction = direction;
  axis.desired = static_cast<int>(axis.ramp.start);
  axis.pwm = 0;
  axis.total = 0;
  axis.turns_left = std::abs(turns);
  axis.target = axis.turns_left * static_cast<int64_t>(kClicksPerUnit);
  axis.brake_point = axis.target / 2;
  axis.timer = axis.ramp.step_ticks;
  axis.accelerating = true;
  axis.braking = false;
}

void PanTiltEmulator::execute(const Command& command) {
  const int first = command.values[0];
  const auto echo = [&] { print(std::string(1, command.letter) + '\n'); };
  switch (command.letter) {
    case 'g':
      echo();
      return go_to(pan_, std::min(first, options_.pan_limit_units), right_stop(), left_stop());
    case 'e':
      echo();
      return go_to(tilt_, std::min(first, options_.tilt_limit_units), low_stop(), false);
    case 'k':
      pan_.ramp = {command.values[0], command.values[1], command.values[2]};
      return echo();
    case 'K':
      tilt_.ramp = {command.values[0], command.values[1], command.values[2]};
      return echo();
    case 'l': {
      PanTiltStatus status;
      status.full = options_.listing_status;
      status.pan_units = pan_.units;
      status.pan_clicks = static_cast<int>(pan_.since_index);
      status.tilt_units = tilt_.units;
      status.tilt_clicks = static_cast<int>(tilt_.since_index);
      status.left_stop = left_stop();
      status.right_stop = right_stop();
      status.low_stop = low_stop();
      status.pan_on = pan_.on;
      status.tilt_on = tilt_.on;
      return print(encode_pantilt_status(status));
    }
    case 'p':
    case 'P':
      if (options_.listing_stop) return;
      stop(pan_);
      stop(tilt_);
      return echo();
    case 'w':
      wait_armed_ = true;
      wait_ticks_ = first;
      wait_pan_ = command.count == 3 && command.values[1] != 0;
      wait_tilt_ = command.count == 3 && command.values[2] != 0;
      return;
    case '*':
      return echo();
    default:
      return;
  }
}

}  // namespace marco::drivers::hcs12
