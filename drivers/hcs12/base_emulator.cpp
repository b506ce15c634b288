#include "drivers/hcs12/base_emulator.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

constexpr int kProportional = 50;  // of a hundred

constexpr const char* kHelp =
    "z<n> zumbador\na<c> avance\nr<c> retroceso\ni<c> izquierda\nd<c> derecha\np paro\n"
    "l lectura\nw<ms> <Fi> <Fd> <Fs> espera\nk<Pi> <Pf> <Tc> rampa\nt baterias\n"
    "S<d0> .. orden\ns sonar\nv<L> <R> velocidad\n";

}  // namespace

BaseEmulator::BaseEmulator(BaseWorld world, const BaseEmulatorOptions& options)
    : battery_v_(std::move(world.battery_v)),
      sonar_(std::move(world.sonar_range_m), {options.sonar_form}) {
  left_.model = {options.left_gain, MotorModel{}.time_constant_ticks, options.ideal_wheels};
  right_.model = {options.right_gain, MotorModel{}.time_constant_ticks, options.ideal_wheels};
}

void BaseEmulator::restart() {
  stop_motors();
  left_.total = right_.total = 0;
  left_.desired = right_.desired = 0;
  ramp_ = {};
  target_ = integral_ = 0;
  bias_ = 0;
  buzzer_ = false;
  sonar_.restart();
  print("Robot ROCA-MOBILE-2 v1.0 listo\n");
}

void BaseEmulator::physics_tick() {
  ++ticks_;
  left_.turn();
  right_.turn();
}

void BaseEmulator::firmware_tick() {
  left_.read_counter();
  right_.read_counter();
  if (motors_on()) speed_control();
  follow_ramp();
  sonar_.tick();
}

void BaseEmulator::speed_control() {
  left_.total += left_.speed_read;
  right_.total += right_.speed_read;
  integral_ += left_.speed_read + bias_ - right_.speed_read;
  const int equalize = static_cast<int>(integral_ / 100);
  const auto correct = [](Motor& wheel, int error) {
    wheel.pwm = std::clamp(wheel.pwm + kProportional * error / 100, 0, kPwmMax);
  };
  correct(left_, left_.desired - left_.speed_read - equalize);
  correct(right_, right_.desired - right_.speed_read + equalize);
}

void BaseEmulator::follow_ramp() {
  const int change = ramp_.step(left_.speed_read, left_.total);
  if (change > 0) {
    if (left_.desired < static_cast<int>(ramp_.ramp.top)) ++left_.desired;
    ++right_.desired;  // the listing gives it no top
  } else if (change < 0 && left_.desired > 0) {
    --left_.desired;
    --right_.desired;
  }
}

void BaseEmulator::main_loop() {
  if (target_ != 0 && left_.total >= target_ && right_.total >= target_) stop_motors();
  if (left_.on) ramp_.brake_if_due(left_.total);
}

void BaseEmulator::stop_motors() {
  left_.stop(kPwmMax);
  right_.stop(kPwmMax);
}

void BaseEmulator::set_velocity(int left, int right) {
  if (left == 0 && right == 0) return stop_motors();
  integral_ = 0;
  left_.start(left > 0 ? 1 : -1, std::abs(left));
  right_.start(right > 0 ? 1 : -1, std::abs(right));
}

void BaseEmulator::start_run(int64_t clicks, const WheelSigns& signs) {
  target_ = clicks;
  left_.total = right_.total = 0;
  // Clicks of a wheel at rest belong to nobody.
  left_.read_counter();
  right_.read_counter();
  bias_ = 0;
  ramp_.start(clicks);
  const int start = static_cast<int>(ramp_.ramp.start);
  set_velocity(signs.left * start, signs.right * start);
}

std::string BaseEmulator::wheel_status() const {
  return encode_wheel_status({static_cast<uint32_t>(left_.total),
                              static_cast<uint32_t>(right_.total), left_.on, right_.on,
                              sonar_.on()});
}

std::string BaseEmulator::batteries() const {
  const std::array<double, 4> volts =
      battery_v_ ? battery_v_() : std::array<double, 4>{12.716, 25.394, 12.859, 25.837};
  BatteryMillivolts millivolts;
  for (std::size_t i = 0; i < 4; ++i) {
    millivolts[i] = battery_millivolts(i, battery_adc(i, volts[i]));
  }
  return encode_batteries(millivolts);
}

void BaseEmulator::execute(const Command& command) {
  const auto& values = command.values;
  if (const auto signs = wheel_signs(command.letter)) {
    start_run(int64_t{values[0]} * 100, *signs);
    return echo(command);
  }
  switch (command.letter) {
    case 'p':
      stop_motors();
      return echo(command);
    case 'z':
      buzzer_ = values[0] != 0;
      return echo(command);
    case 'k':
      ramp_.ramp = {values[0], values[1], values[2]};
      return echo(command);
    case 'v':
      bias_ = command.count >= 3 ? values[2] - 100 : 0;
      set_velocity(values[0] - 100, values[1] - 100);
      return echo(command);
    case 'S':
      sonar_.set_order(command);
      return echo(command);
    case '*':
      return echo(command);
    case 'l':
      return print(wheel_status());
    case 't':
      return print(batteries());
    case 's':
      return print(sonar_.execute(command));
    case 'q':
      return print("sonar_wait=" + std::to_string(sonar_.shots_left()) + "\n");
    case '?':
      return print(kHelp);
    case 'w':
      return arm_wait(command);
    default:
      return;  // unknown letters get no reply at all
  }
}

}  // namespace marco::drivers::hcs12
