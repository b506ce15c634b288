#include "simulator/devices/hcs12/pantilt_emulator.hpp"

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
  pan_.model.ideal = tilt_.model.ideal = options.ideal_wheels;
  tilt_.min_gap = 251;
}

void PanTiltEmulator::restart() {
  for (Axis* axis : {&pan_, &tilt_}) {
    axis->stop();
    axis->control_ramp.ramp = Ramp{3, 50, 30};
    axis->units = 0;
    axis->since_index = 0;
  }
  homing_ = Homing::right;
  pan_.seek(-1, kSeekSpeed);
  print("Sistema ROCA-PANT-TILT v1.0\nGirando a la derecha\n");
}

void PanTiltEmulator::Axis::turn() {
  // A pulse sits on each multiple; coming up it is met on reaching it, going down on leaving it.
  const double before = std::floor(position / kClicksPerUnit);
  Motor::turn();
  if (std::floor(position / kClicksPerUnit) != before) index_passed = true;
}

void PanTiltEmulator::Axis::stop() {
  Motor::stop(0);
  turns_left = 0;
}

void PanTiltEmulator::Axis::count() {
  read_counter();
  indexed = false;
  if (!on) {
    index_passed = false;
    return;
  }
  total += speed_read;
  since_index += int64_t{direction} * speed_read;
  if (!std::exchange(index_passed, false)) return;
  if (std::abs(since_index) < min_gap) return;  // the same pulse again
  units += direction;
  since_index = 0;
  indexed = true;
  if (turns_left > 0 && --turns_left == 0) stop();
}

void PanTiltEmulator::Axis::control() {
  if (on) pwm = std::clamp(pwm + (desired - speed_read), 0, kPwmMax);
}

void PanTiltEmulator::Axis::follow_ramp() {
  if (!on || turns_left == 0) return;
  control_ramp.brake_if_due(total);
  const int change = control_ramp.step(speed_read, total);
  const Ramp& ramp = control_ramp.ramp;
  if (change > 0 && desired < static_cast<int>(ramp.top)) ++desired;
  if (change < 0 && desired > static_cast<int>(ramp.start)) --desired;
}

void PanTiltEmulator::Axis::seek(int new_direction, int new_desired) {
  Motor::start(new_direction, new_desired);
  turns_left = 0;
  index_passed = false;
}

void PanTiltEmulator::Axis::go_to(int unit, bool lower_stop, bool upper_stop) {
  const int turns = unit - units;
  if (turns == 0) return stop();
  if (turns > 0 ? upper_stop : lower_stop) return;
  Motor::start(turns < 0 ? -1 : 1, static_cast<int>(control_ramp.ramp.start));
  total = 0;
  turns_left = std::abs(turns);
  control_ramp.start(turns_left * static_cast<int64_t>(kClicksPerUnit));
}

void PanTiltEmulator::physics_tick() {
  pan_.turn();
  tilt_.turn();
}

void PanTiltEmulator::firmware_tick() {
  for (Axis* axis : {&pan_, &tilt_}) {
    axis->count();
    axis->control();
    axis->follow_ramp();
  }
  if (!homed()) return;
  if (pan_.direction > 0 ? left_stop() : right_stop()) pan_.stop();
  if (tilt_.direction < 0 && low_stop()) tilt_.stop();
}

void PanTiltEmulator::main_loop() {
  if (!homed()) homing_step();
}

void PanTiltEmulator::homing_step() {
  const auto next = [this](Homing homing, const char* text) {
    homing_ = homing;
    print(text);
  };
  switch (homing_) {
    case Homing::right:
      if (!right_stop()) return;
      pan_.seek(1, kLeaveSpeed);
      return next(Homing::leave_right, "Se alcanz\xF3 el tope derecho\nGirando a la izquierda\n");
    case Homing::leave_right:
      if (right_stop()) return;
      pan_.since_index = pan_.min_gap;
      return next(Homing::pan_index, "Se liber\xF3 el tope derecho\nGiro de 1 unidad\n");
    case Homing::pan_index:
      if (!pan_.indexed) return;
      pan_.stop();
      pan_.units = 0;
      tilt_.seek(-1, kSeekSpeed);
      return next(Homing::down, "Motor de giro apagado\nHacia abajo\n");
    case Homing::down:
      if (!low_stop()) return;
      tilt_.seek(1, kLeaveSpeed);
      return next(Homing::leave_low, "Se alcanz\xF3 el tope inferior\nHacia arriba\n");
    case Homing::leave_low:
      if (low_stop()) return;
      tilt_.since_index = tilt_.min_gap;
      return next(Homing::tilt_index, "Se liber\xF3 el tope inferior\nHacia arriba 1 unidad\n");
    case Homing::tilt_index:
      if (!tilt_.indexed) return;
      tilt_.stop();
      tilt_.units = 0;
      return next(Homing::done, "Motor de inclinaci\xF3n apagado\nListo\n");
    case Homing::done:
      return;
  }
}

std::string PanTiltEmulator::status() const {
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
  return encode_pantilt_status(status);
}

void PanTiltEmulator::execute(const Command& command) {
  const auto& values = command.values;
  switch (command.letter) {
    case 'g':
      echo(command);
      return pan_.go_to(std::min<int>(values[0], options_.pan_limit_units), right_stop(),
                        left_stop());
    case 'e':
      echo(command);
      return tilt_.go_to(std::min<int>(values[0], options_.tilt_limit_units), low_stop(), false);
    case 'k':
    case 'K':
      (command.letter == 'k' ? pan_ : tilt_).control_ramp.ramp = {values[0], values[1], values[2]};
      return echo(command);
    case 'l':
      return print(status());
    case 'p':
    case 'P':
      if (options_.listing_stop) return;
      pan_.stop();
      tilt_.stop();
      return echo(command);
    case 'w':
      return arm_wait(command);
    case '*':
      return echo(command);
    default:
      return;
  }
}

}  // namespace marco::drivers::hcs12
