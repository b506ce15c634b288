#include "drivers/hcs12/base_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace marco::drivers::hcs12 {
namespace {

constexpr int kProportional = 50;  // of a hundred

}  // namespace

BaseEmulator::BaseEmulator(BaseWorld world, const BaseEmulatorOptions& options)
    : world_(std::move(world)), options_(options) {
  left_.gain = options.left_gain;
  right_.gain = options.right_gain;
}

void BaseEmulator::restart() {
  stop_motors();
  left_.total = right_.total = 0;
  left_.desired = right_.desired = 0;
  ramp_ = Ramp{};
  target_ = brake_point_ = integral_ = 0;
  bias_ = 0;
  ramp_timer_ = 0;
  accelerating_ = braking_ = buzzer_ = false;
  wait_ = Wait{};
  order_.resize(16);
  std::iota(order_.begin(), order_.end(), 0U);
  readings_.fill(kNoEcho);
  sonar_on_ = false;
  listen_ms_ = 50;
  rest_ms_ = 20;
  rounds_ = shots_left_ = 0;
  print("Robot ROCA-MOBILE-2 v1.0 listo\n");
}

void BaseEmulator::turn_wheel(Wheel& wheel) const {
  if (!wheel.on) {
    wheel.speed = 0.0;
    return;
  }
  const double wanted =
      (wheel.ahead ? 1.0 : -1.0) * (options_.ideal_wheels ? wheel.desired : wheel.gain * wheel.pwm);
  const double follow =
      options_.ideal_wheels ? 1.0 : 1.0 - std::exp(-1.0 / options_.wheel_time_constant_ticks);
  wheel.speed += follow * (wanted - wheel.speed);
  wheel.position += wheel.speed;
  wheel.travel += std::abs(wheel.speed);
}

void BaseEmulator::physics_tick() {
  ++ticks_;
  turn_wheel(left_);
  turn_wheel(right_);
}

int BaseEmulator::read_counter(Wheel& wheel) {
  const auto passed = static_cast<int64_t>(std::floor(wheel.travel + 1e-9)) - wheel.counted;
  wheel.counted += passed;
  return static_cast<int>(std::min<int64_t>(passed, kAccumulatorMax));
}

void BaseEmulator::firmware_tick() {
  left_.speed_read = read_counter(left_);
  right_.speed_read = read_counter(right_);
  speed_control();
  ac_control();
  sonar_tick();
  if (wait_.armed) --wait_.ticks;
}

void BaseEmulator::speed_control() {
  if (!left_.on && !right_.on) return;
  left_.total += left_.speed_read;
  right_.total += right_.speed_read;
  integral_ += left_.speed_read + bias_ - right_.speed_read;
  const int equalize = static_cast<int>(integral_ / 100);
  const auto correct = [](Wheel& wheel, int error) {
    wheel.pwm = std::clamp(wheel.pwm + kProportional * error / 100, 0, kPwmMax);
  };
  correct(left_, left_.desired - left_.speed_read - equalize);
  correct(right_, right_.desired - right_.speed_read + equalize);
}

void BaseEmulator::ac_control() {
  if (ramp_timer_ > 0) {
    --ramp_timer_;
    return;
  }
  if (accelerating_) {
    if (left_.speed_read + 3 >= static_cast<int>(ramp_.top)) {
      brake_point_ = target_ - left_.total;
      accelerating_ = false;
    }
    if (left_.desired < static_cast<int>(ramp_.top)) ++left_.desired;
    ++right_.desired;  // the listing gives it no top
  } else if (braking_ && left_.desired > 0) {
    --left_.desired;
    --right_.desired;
  }
  ramp_timer_ = ramp_.step_ticks;
}

void BaseEmulator::main_loop() {
  if (target_ != 0 && left_.total >= target_ && right_.total >= target_ && motors_on()) {
    stop_motors();
  }
  if (left_.on && !braking_ && left_.total >= brake_point_) {
    accelerating_ = false;
    braking_ = true;
  }
  if (!wait_.armed) return;
  const bool motors_off = (!wait_.left || !left_.on) && (!wait_.right || !right_.on);
  const bool sonar_ready = !wait_.sonar || shots_left_ <= 0;
  if (wait_.ticks <= 0 || (wait_.flags && motors_off && sonar_ready)) {
    wait_.armed = false;
    print("w\n");
  }
}

void BaseEmulator::stop_motors() {
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->on = false;
    wheel->pwm = kPwmMax;
    wheel->speed = 0.0;
  }
}

void BaseEmulator::set_velocity(int left, int right) {
  if (left == 0 && right == 0) {
    stop_motors();
    return;
  }
  integral_ = 0;
  const auto set = [](Wheel& wheel, int speed) {
    wheel.on = true;
    wheel.pwm = 0;
    wheel.desired = std::abs(speed);
    wheel.ahead = speed > 0;
  };
  set(left_, left);
  set(right_, right);
}

void BaseEmulator::set_params(uint32_t tenths, int left_sign, int right_sign) {
  target_ = static_cast<int64_t>(tenths) * 100;
  left_.total = right_.total = 0;
  // Clicks of a wheel at rest belong to nobody.
  read_counter(left_);
  read_counter(right_);
  brake_point_ = target_ / 2;
  bias_ = 0;
  ramp_timer_ = ramp_.step_ticks;
  accelerating_ = true;
  braking_ = false;
  const int start = static_cast<int>(ramp_.start);
  set_velocity(left_sign * start, right_sign * start);
}

void BaseEmulator::execute(const Command& command) {
  const uint32_t first = command.values[0];
  const auto echo = [&] { print(std::string(1, command.letter) + '\n'); };
  switch (command.letter) {
    case 'a':
      set_params(first, 1, 1);
      return echo();
    case 'r':
      set_params(first, -1, -1);
      return echo();
    case 'i':
      set_params(first, -1, 1);
      return echo();
    case 'd':
      set_params(first, 1, -1);
      return echo();
    case 'p':
      stop_motors();
      return echo();
    case 'z':
      buzzer_ = first != 0;
      return echo();
    case 'k':
      ramp_ = {first, command.values[1], command.values[2]};
      return echo();
    case 'v':
      bias_ = command.count >= 3 ? static_cast<int>(command.values[2]) - 100 : 0;
      set_velocity(static_cast<int>(first) - 100, static_cast<int>(command.values[1]) - 100);
      return echo();
    case 'l':
      return print(encode_wheel_status({static_cast<uint32_t>(left_.total),
                                        static_cast<uint32_t>(right_.total), left_.on, right_.on,
                                        sonar_on_}));
    case 't': {
      const std::array<double, 4> volts =
          world_.battery_v ? world_.battery_v()
                           : std::array<double, 4>{12.716, 25.394, 12.859, 25.837};
      BatteryMillivolts millivolts;
      for (std::size_t i = 0; i < 4; ++i) {
        millivolts[i] = battery_millivolts(i, battery_adc(i, volts[i]));
      }
      return print(encode_batteries(millivolts));
    }
    case 'w':
      return arm_wait(command);
    case 'S':
      order_.assign(command.values.begin(),
                    command.values.begin() +
                        static_cast<std::ptrdiff_t>(std::min<std::size_t>(command.count, 16)));
      return echo();
    case 's':
      return sonar_command(command);
    case 'q':
      return print("sonar_wait=" + std::to_string(shots_left_) + "\n");
    case '*':
      return echo();
    case '?':
      return print_help();
    default:
      return;  // unknown letters get no reply at all
  }
}

void BaseEmulator::arm_wait(const Command& command) {
  wait_ = Wait{};
  wait_.armed = true;
  wait_.ticks = command.values[0];
  wait_.flags = command.count == 4;  // three numbers, as in the manual's example, are a plain delay
  if (wait_.flags) {
    wait_.left = command.values[1] != 0;
    wait_.right = command.values[2] != 0;
    wait_.sonar = command.values[3] != 0;
    wait_.flags = wait_.left || wait_.right || wait_.sonar;
  }
}

void BaseEmulator::sonar_command(const Command& command) {
  if (command.count == 0) {
    std::vector<uint32_t> times;
    for (const uint32_t transducer : order_) times.push_back(readings_[transducer % 16]);
    print(encode_sonar(times, options_.sonar_form));
    shots_left_ = static_cast<int64_t>(order_.size()) + 1;
    return;
  }
  if (command.values[0] > 2) return print("s" + std::to_string(rounds_) + "\n");
  if (command.values[0] == 2) {
    listen_ms_ = command.values[1];
    rest_ms_ = command.values[2];
  } else {
    sonar_on_ = command.values[0] == 1;
    if (sonar_on_) {
      readings_.fill(kNoEcho);
      shot_ = shot_tick_ = 0;
      shots_left_ = static_cast<int64_t>(order_.size());
    }
  }
  print("s\n");
}

void BaseEmulator::sonar_tick() {
  if (!sonar_on_ || order_.empty()) return;
  // Fire, blanking off, listening, rest, next.
  const uint32_t listened = 2 + listen_ms_;
  ++shot_tick_;
  if (shot_tick_ == listened) read_shot();
  if (shot_tick_ < listened + rest_ms_ + 1) return;
  shot_tick_ = 0;
  if (++shot_ >= order_.size()) {
    shot_ = 0;
    ++rounds_;
  }
}

void BaseEmulator::read_shot() {
  const std::size_t transducer = order_[shot_ % order_.size()] % 16;
  const double range_m = world_.sonar_range_m ? world_.sonar_range_m(transducer) : HUGE_VAL;
  const uint32_t units =
      std::isfinite(range_m) ? sonar_time_units(range_m, options_.speed_of_sound_m_per_s) : kNoEcho;
  const bool in_window = units * kSonarUnitUs <= static_cast<double>(listen_ms_ * kTickUs);
  readings_[transducer] = in_window ? units : kNoEcho;
  if (shots_left_ > 0) --shots_left_;
}

void BaseEmulator::print_help() {
  print(
      "z<n> zumbador\na<c> avance\nr<c> retroceso\ni<c> izquierda\nd<c> derecha\np paro\n"
      "l lectura\nw<ms> <Fi> <Fd> <Fs> espera\nk<Pi> <Pf> <Tc> rampa\nt baterias\n"
      "S<d0> .. orden\ns sonar\nv<L> <R> velocidad\n");
}

}  // namespace marco::drivers::hcs12
