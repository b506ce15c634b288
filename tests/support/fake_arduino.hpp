#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <string>

/// As much of an Arduino as the sketch in examples/arduino uses, with two motors and their encoders
/// behind its pins. The sketch is compiled against it as C++.
namespace marco::testing {

/// A motor that reaches a speed for its PWM after a while, and an encoder of two channels.
struct FakeMotor {
  int direction_pin, pwm_pin, a_pin, b_pin;
  double ticks_per_s_at_full = 3000.0;
  double lag_s = 0.05;
  double speed = 0.0;      ///< ticks a second
  double travelled = 0.0;  ///< ticks, ahead > 0
  bool blocked = false;
};

/// Pins, clock, serial line and motors.
class FakeArduino {
 public:
  std::map<int, int> outputs;               ///< what was written to a pin, digital or PWM
  std::map<int, int> inputs;                ///< of pins that are not high
  std::map<int, void (*)()> interrupts_on;  ///< by pin
  std::string printed;                      ///< and not yet taken
  std::deque<char> typed;                   ///< and not yet read
  double now_s = 0.0;
  FakeMotor left{7, 5, 2, 4}, right{8, 6, 3, 9};

  int read(int pin) const {
    const auto found = inputs.find(pin);
    return found == inputs.end() ? 1 : found->second;
  }

  /// Time passes; encoders call their interrupts at each edge of channel A.
  void run(double dt_s) {
    now_s += dt_s;
    for (FakeMotor* motor : {&left, &right}) turn(*motor, dt_s);
  }

 private:
  void turn(FakeMotor& motor, double dt_s) {
    const double sign = outputs[motor.direction_pin] != 0 ? 1.0 : -1.0;
    const double goal =
        motor.blocked ? 0.0 : sign * outputs[motor.pwm_pin] / 255.0 * motor.ticks_per_s_at_full;
    motor.speed += (1.0 - std::exp(-dt_s / motor.lag_s)) * (goal - motor.speed);
    const double before = motor.travelled;
    motor.travelled += motor.speed * dt_s;
    const auto from = static_cast<int64_t>(std::floor(before));
    const auto to = static_cast<int64_t>(std::floor(motor.travelled));
    for (int64_t tick = from; tick != to; tick += to > from ? 1 : -1) {
      edge(motor, to > from ? tick + 1 : tick, to > from);
    }
  }
  // A is high in odd ticks; B follows it by half a tick when the wheel turns ahead.
  void edge(const FakeMotor& motor, int64_t tick, bool ahead) {
    const bool a_after = ahead ? tick % 2 != 0 : tick % 2 == 0;
    inputs[motor.a_pin] = a_after ? 1 : 0;
    inputs[motor.b_pin] = a_after == ahead ? 0 : 1;
    if (interrupts_on.contains(motor.a_pin)) interrupts_on[motor.a_pin]();
  }
};

inline FakeArduino& fake_arduino() {
  static FakeArduino arduino;
  return arduino;
}

}  // namespace marco::testing

/// Arduino.h.
namespace arduino {

using std::snprintf;
using std::strcmp;
using std::strrchr;
using std::strtol;
using std::strtoul;

constexpr int LOW = 0, HIGH = 1, INPUT_PULLUP = 2, OUTPUT = 3, CHANGE = 4, A0 = 14;

inline unsigned long millis() {
  return static_cast<unsigned long>(marco::testing::fake_arduino().now_s * 1000.0);
}
inline void pinMode(int, int) {}
inline void digitalWrite(int pin, int value) {
  marco::testing::fake_arduino().outputs[pin] = value;
}
inline void analogWrite(int pin, int value) { marco::testing::fake_arduino().outputs[pin] = value; }
inline int digitalRead(int pin) { return marco::testing::fake_arduino().read(pin); }
inline long analogRead(int) { return 512; }
inline int digitalPinToInterrupt(int pin) { return pin; }
inline void attachInterrupt(int pin, void (*call)(), int) {
  marco::testing::fake_arduino().interrupts_on[pin] = call;
}
inline void noInterrupts() {}
inline void interrupts() {}

struct SerialPort {
  void begin(long) const {}
  int available() const { return static_cast<int>(marco::testing::fake_arduino().typed.size()); }
  int read() const {
    std::deque<char>& typed = marco::testing::fake_arduino().typed;
    if (typed.empty()) return -1;
    const char c = typed.front();
    typed.pop_front();
    return c;
  }
  void print(const char* text) const { marco::testing::fake_arduino().printed += text; }
};
inline constexpr SerialPort Serial;

}  // namespace arduino
