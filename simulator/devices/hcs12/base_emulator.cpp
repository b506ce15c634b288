#include "simulator/devices/hcs12/base_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

constexpr int kProportional = 50;  // of a hundred

constexpr const char* kHelp =
    "z<n> zumbador\na<c> avance\nr<c> retroceso\ni<c> izquierda\nd<c> derecha\np paro\n"
    "l lectura\nw<ms> <Fi> <Fd> <Fs> espera\nk<Pi> <Pf> <Tc> rampa\nt baterias\n"
    "S<d0> .. orden\ns sonar\nv<L> <R> velocidad\n";

}  // namespace

SonarSequencer::SonarSequencer(Range range_m, const Options& options)
    : range_m_(std::move(range_m)), options_(options) {}

// The shot that was in progress is kept, as on the board.
void SonarSequencer::restart() {
  order_.resize(16);
  std::iota(order_.begin(), order_.end(), 0U);
  readings_.fill(kNoEcho);
  on_ = false;
  listen_ms_ = 50;
  rest_ms_ = 20;
  rounds_ = shots_left_ = 0;
}

void SonarSequencer::set_order(const Command& command) {
  const std::size_t count = std::min<std::size_t>(command.count, 16);
  order_.assign(command.values.begin(),
                command.values.begin() + static_cast<std::ptrdiff_t>(count));
}

std::string SonarSequencer::execute(const Command& command) {
  if (command.count == 0) {
    std::vector<uint32_t> times;
    for (const uint32_t transducer : order_) times.push_back(readings_[transducer % 16]);
    shots_left_ = static_cast<int64_t>(order_.size()) + 1;
    return encode_sonar(times, options_.form);
  }
  if (command.values[0] > 2) return "s" + std::to_string(rounds_) + "\n";
  if (command.values[0] == 2) {
    listen_ms_ = command.values[1];
    rest_ms_ = command.values[2];
    return "s\n";
  }
  on_ = command.values[0] == 1;
  if (on_) {
    readings_.fill(kNoEcho);
    shot_ = shot_tick_ = 0;
    shots_left_ = static_cast<int64_t>(order_.size());
  }
  return "s\n";
}

void SonarSequencer::tick() {
  if (!on_ || order_.empty()) return;
  const uint32_t listened = 2 + listen_ms_;  // after the shot and the blanking
  ++shot_tick_;
  if (shot_tick_ == listened) take_reading();
  if (shot_tick_ < listened + rest_ms_ + 1) return;
  shot_tick_ = 0;
  if (++shot_ >= order_.size()) {
    shot_ = 0;
    ++rounds_;
  }
}

void SonarSequencer::take_reading() {
  const std::size_t transducer = order_[shot_ % order_.size()] % 16;
  const double range_m = range_m_ ? range_m_(transducer) : HUGE_VAL;
  const uint32_t units =
      std::isfinite(range_m) ? sonar_time_units(range_m, options_.speed_of_sound_m_per_s) : kNoEcho;
  const bool in_window = units * kSonarUnitUs <= static_cast<double>(listen_ms_ * kTickUs);
  readings_[transducer] = in_window ? units : kNoEcho;
  if (shots_left_ > 0) --shots_left_;
}

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
