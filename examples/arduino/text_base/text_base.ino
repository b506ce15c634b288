// The board of a home-made robot for marco-textbase: docs/text_base.md describes its protocol.
//
// For an Arduino Uno or Nano, two motors with encoders, and a motor driver that takes a direction and
// a PWM for each (L298N, TB6612). Change the constants below to your robot; ticks, wheels and track
// belong into marco-textbase's configuration. Put it on blocks first: with both wheels free, `M 300 300`
// in the serial monitor (115200 baud, newline) must turn both forward, and `T` must count up.

const char kName[] = "mybot";
const char kFirmware[] = "1.0";

struct WheelPins {
  int direction;  // HIGH = ahead
  int pwm;
  int encoder_a;  // with an interrupt: 2 or 3
  int encoder_b;
};
const WheelPins kPins[2] = {{7, 5, 2, 4}, {8, 6, 3, 9}};  // left, right
const int kLeftBumperPin = 10;                            // switches to ground
const int kRightBumperPin = 11;
const int kEmergencyStopPin = 12;  // to ground = pressed
const int kBatteryPin = A0;
const long kMicrovoltsPerStep = 0;  // of the battery, by its divider; 0 = not measured

const float kPwmPerTick = 0.08f;       // what a wheel needs for a tick a second
const float kPwmPerMissedTick = 0.1f;  // and for each tick it is behind
const long kMostTicksPerSecond = 4000;

const unsigned long kControlMs = 10;
const int kMaxLine = 80;
const long kFlagMotors = 1, kFlagWatchdog = 2, kFlagLeft = 4, kFlagRight = 8, kFlagStop = 16;

struct State {
  char line[kMaxLine + 1];
  int length;
  bool overlong;
  bool has_sums;  // the host sends sums: so do we
  long goal[2];   // ticks a second
  float behind[2];
  long counted[2];
  bool motors_on;
  bool watchdog_stopped;
  bool was_stopped;  // the red button, when it was looked at last
  long watchdog_ms;
  long report_ms;  // 0 = none
  unsigned long moved_at, controlled_at, reported_at, measured_at;
};
State state;
volatile long ticks[2];

void count(int wheel) {
  const bool rises = digitalRead(kPins[wheel].encoder_a) == HIGH;
  const bool leads = digitalRead(kPins[wheel].encoder_b) == LOW;
  ticks[wheel] = ticks[wheel] + (rises == leads ? 1 : -1);
}
void count_left() { count(0); }
void count_right() { count(1); }

long ticks_of(int wheel) {
  noInterrupts();
  const long value = ticks[wheel];
  interrupts();
  return value;
}

unsigned int sum_of(const char* text) {
  unsigned int sum = 0;
  for (; *text != '\0'; ++text) sum ^= static_cast<unsigned char>(*text);
  return sum;
}

void say(const char* text) {
  Serial.print(text);
  if (state.has_sums) {
    char sum[8];
    snprintf(sum, sizeof sum, "*%02X", sum_of(text));
    Serial.print(sum);
  }
  Serial.print("\n");
}

void say_hello() {
  char text[kMaxLine + 1];
  snprintf(text, sizeof text, "V 1 %s %s wd=%ld", kName, kFirmware, state.watchdog_ms);
  say(text);
}

void say_done(char setting, long value) {
  char text[24];
  snprintf(text, sizeof text, "K %c %ld", setting, value);
  say(text);
}

void set_wheel(int wheel, float pwm) {
  const float most = 255.0f;
  const float size = pwm < 0.0f ? -pwm : pwm;
  digitalWrite(kPins[wheel].direction, pwm < 0.0f ? LOW : HIGH);
  analogWrite(kPins[wheel].pwm, static_cast<int>(size < most ? size : most));
}

void stop_wheels() {
  for (int wheel = 0; wheel < 2; ++wheel) {
    state.goal[wheel] = 0;
    state.behind[wheel] = 0.0f;
    set_wheel(wheel, 0.0f);
  }
  state.motors_on = false;
}

bool stop_is_pressed() { return digitalRead(kEmergencyStopPin) == LOW; }

long flags() {
  return (state.motors_on ? kFlagMotors : 0) | (state.watchdog_stopped ? kFlagWatchdog : 0) |
         (digitalRead(kLeftBumperPin) == LOW ? kFlagLeft : 0) |
         (digitalRead(kRightBumperPin) == LOW ? kFlagRight : 0) |
         (stop_is_pressed() ? kFlagStop : 0);
}

// Reads " 12 -3": so many numbers, a space before each, and nothing behind. @returns whether.
bool read_numbers(const char* at, long* values, int count) {
  for (int i = 0; i < count; ++i) {
    if (*at != ' ' || at[1] == ' ') return false;
    char* end = nullptr;
    values[i] = strtol(at + 1, &end, 10);
    if (end == at + 1) return false;
    at = end;
  }
  return *at == '\0';
}

long limited(long value) {
  if (value > kMostTicksPerSecond) return kMostTicksPerSecond;
  return value < -kMostTicksPerSecond ? -kMostTicksPerSecond : value;
}

void move_wheels(const long* speeds) {
  state.moved_at = millis();
  state.watchdog_stopped = false;
  if (stop_is_pressed()) return;
  state.motors_on = true;
  for (int wheel = 0; wheel < 2; ++wheel) state.goal[wheel] = limited(speeds[wheel]);
}

void obey(char* line) {
  char* star = strrchr(line, '*');
  if (star != nullptr) {
    char* end = nullptr;
    const unsigned long given = strtoul(star + 1, &end, 16);
    const bool whole = end == star + 3 && *end == '\0';
    *star = '\0';
    if (!whole || given != sum_of(line)) return say("E 2 checksum");
    state.has_sums = true;
  }
  long values[2];
  if (strcmp(line, "V?") == 0) {
    say_hello();
  } else if (line[0] == 'M' && read_numbers(line + 1, values, 2)) {
    move_wheels(values);
  } else if (line[0] == 'W' && read_numbers(line + 1, values, 1)) {
    if (values[0] < 100 || values[0] > 2000) return say("E 3 value");
    state.watchdog_ms = values[0];
    say_done('W', values[0]);
  } else if (line[0] == 'R' && read_numbers(line + 1, values, 1)) {
    if (values[0] < 5 || values[0] > 1000) return say("E 3 value");
    state.report_ms = values[0];
    state.reported_at = millis();
    say_done('R', values[0]);
  } else {
    say("E 1 line");
  }
}

void listen() {
  while (Serial.available() > 0) {
    const char c = static_cast<char>(Serial.read());
    if (c == '\r') continue;
    if (c == '\n') {
      state.line[state.length] = '\0';
      if (state.overlong) {
        say("E 1 line");
      } else if (state.length > 0) {
        obey(state.line);
      }
      state.length = 0;
      state.overlong = false;
    } else if (state.length < kMaxLine) {
      state.line[state.length++] = c;
    } else {
      state.overlong = true;
    }
  }
}

void control() {
  const float seconds = static_cast<float>(kControlMs) / 1000.0f;
  for (int wheel = 0; wheel < 2; ++wheel) {
    const long now = ticks_of(wheel);
    const float went = static_cast<float>(now - state.counted[wheel]);
    state.counted[wheel] = now;
    const float goal = static_cast<float>(state.goal[wheel]);
    const float most = 1000.0f;
    float behind = state.behind[wheel] + goal * seconds - went;
    if (behind > most) behind = most;
    if (behind < -most) behind = -most;
    state.behind[wheel] = state.goal[wheel] == 0 ? 0.0f : behind;
    if (!state.motors_on) continue;
    set_wheel(wheel, goal * kPwmPerTick + state.behind[wheel] * kPwmPerMissedTick);
  }
}

void watch() {
  const bool is_stopped = stop_is_pressed();
  if (is_stopped && !state.was_stopped) {
    stop_wheels();
    say("E 7 emergency stop");
  }
  state.was_stopped = is_stopped;
  if (!state.motors_on) return;
  if (millis() - state.moved_at <= static_cast<unsigned long>(state.watchdog_ms)) return;
  stop_wheels();
  state.watchdog_stopped = true;
  say("E 4 watchdog");
}

void report() {
  char text[kMaxLine + 1];
  const long left = ticks_of(0);
  const long right = ticks_of(1);
  snprintf(text, sizeof text, "T %lu %ld %ld %ld", millis(), left, right, flags());
  say(text);
}

void measure_battery() {
  char text[24];
  snprintf(text, sizeof text, "B %ld", analogRead(kBatteryPin) * kMicrovoltsPerStep / 1000);
  say(text);
}

void setup() {
  state = State();
  state.watchdog_ms = 500;
  ticks[0] = 0;
  ticks[1] = 0;
  for (int wheel = 0; wheel < 2; ++wheel) {
    pinMode(kPins[wheel].direction, OUTPUT);
    pinMode(kPins[wheel].pwm, OUTPUT);
    pinMode(kPins[wheel].encoder_a, INPUT_PULLUP);
    pinMode(kPins[wheel].encoder_b, INPUT_PULLUP);
  }
  pinMode(kLeftBumperPin, INPUT_PULLUP);
  pinMode(kRightBumperPin, INPUT_PULLUP);
  pinMode(kEmergencyStopPin, INPUT_PULLUP);
  stop_wheels();
  attachInterrupt(digitalPinToInterrupt(kPins[0].encoder_a), count_left, CHANGE);
  attachInterrupt(digitalPinToInterrupt(kPins[1].encoder_a), count_right, CHANGE);
  Serial.begin(115200);
  say_hello();
}

void loop() {
  listen();
  watch();
  const unsigned long now = millis();
  if (now - state.controlled_at >= kControlMs) {
    state.controlled_at += kControlMs;
    control();
  }
  const unsigned long every = static_cast<unsigned long>(state.report_ms);
  if (every > 0 && now - state.reported_at >= every) {
    state.reported_at += every;
    report();
  }
  if (kMicrovoltsPerStep > 0 && every > 0 && now - state.measured_at >= 1000) {
    state.measured_at = now;
    measure_battery();
  }
}
