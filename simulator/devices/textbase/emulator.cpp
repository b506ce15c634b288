#include "simulator/devices/textbase/emulator.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::textbase {
namespace {

constexpr Duration kStep = Duration::from_us(5000);
constexpr Duration kBatteryEvery = Duration::from_us(1'000'000);

Duration milliseconds(int value) { return Duration::from_us(int64_t{1000} * value); }

// Counters of 32 bits wrap.
int32_t counted(double ticks) {
  return static_cast<int32_t>(static_cast<uint32_t>(static_cast<int64_t>(std::floor(ticks))));
}

}  // namespace

TextBoard::TextBoard(const TextBoardOptions& options, std::function<unsigned()> touch)
    : options_(options), touch_(std::move(touch)) {}

// The first client's opening powers it; later ones find it running.
void TextBoard::on_connection(bool connected, Utime now) {
  cutter_.clear();
  if (!connected || on_) return;
  reset(now);
}

void TextBoard::reset(Utime now) {
  on_ = true;
  greeted_ = false;
  ready_ = now + Duration::from_seconds(options_.boot_s);
  now_ = now;
  output_.clear();
  cutter_.clear();
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->goal = wheel->speed = 0.0;
    wheel->counted_from = wheel->travelled;
  }
  motors_on_ = watchdog_stopped_ = has_sums_ = false;
  watchdog_ms_ = 500;
  report_ms_ = 0;
  next_battery_ = ready_;
}

unsigned TextBoard::flags() const {
  return (touch_ ? touch_() : 0U) | (motors_on_ ? kMotorsOn : 0U) |
         (watchdog_stopped_ ? kWatchdogStopped : 0U);
}

void TextBoard::say(const BoardLine& line, Utime now) {
  const std::string text = (has_sums_ ? with_sum(encode(line)) : encode(line)) + "\n";
  output_.send({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, now);
}

void TextBoard::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (!on_ || now < ready_ || (baud != 0 && baud != kBaud)) return;
  run_until(now);
  for (const uint8_t byte : bytes) {
    if (const auto line = cutter_.push(byte); line && !line->empty()) on_line(*line, now);
  }
}

void TextBoard::on_line(const std::string& line, Utime now) {
  const auto body = without_sum(line);
  if (!body) return say(Complaint{kBadSum, "checksum"}, now);
  has_sums_ = has_sums_ || body->had_sum;
  const auto parsed = parse_host_line(body->text);
  if (!parsed) return say(Complaint{kBadLine, "no such line"}, now);
  obey(*parsed, now);
}

bool TextBoard::within(int value, int least, int most, Utime now) {
  if (value >= least && value <= most) return true;
  say(Complaint{kBadValue, "value"}, now);
  return false;
}

void TextBoard::obey(const HostLine& line, Utime now) {
  if (std::holds_alternative<WhoAreYou>(line)) {
    say(Hello{kProtocol, "sim", "1.0", watchdog_ms_}, now);
  } else if (const auto* motion = std::get_if<Motion>(&line)) {
    const int most = options_.most_ticks_per_s;
    left_.goal = std::clamp(motion->left_ticks_per_s, -most, most);
    right_.goal = std::clamp(motion->right_ticks_per_s, -most, most);
    motors_on_ = true;
    watchdog_stopped_ = false;
    last_motion_ = now;
  } else if (const auto* watchdog = std::get_if<SetWatchdog>(&line)) {
    if (!within(watchdog->ms, kLeastWatchdogMs, kMostWatchdogMs, now)) return;
    watchdog_ms_ = watchdog->ms;
    say(Done{'W', watchdog->ms}, now);
  } else if (const auto* reports = std::get_if<SetReports>(&line)) {
    if (!within(reports->ms, kLeastReportMs, kMostReportMs, now)) return;
    report_ms_ = reports->ms;
    next_report_ = now;
    say(Done{'R', reports->ms}, now);
  }
}

void TextBoard::turn_wheels(double dt_s) {
  if ((flags() & (kEmergencyStop | kFault)) != 0) left_.goal = right_.goal = 0.0;
  const double part = -std::expm1(-dt_s / options_.lag_s);
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->speed += part * (wheel->goal - wheel->speed);
    if (wheel->goal == 0.0 && std::abs(wheel->speed) < 1.0) wheel->speed = 0.0;
    wheel->travelled += wheel->speed * dt_s;
  }
}

void TextBoard::run_until(Utime now) {
  if (!on_) return;
  while (now_ < now) {
    const Utime next = std::min(now, now_ + kStep);
    turn_wheels((next - now_).seconds());
    now_ = next;
    if (now_ < ready_) continue;
    if (!std::exchange(greeted_, true)) say(Hello{kProtocol, "sim", "1.0", watchdog_ms_}, now_);
    if (motors_on_ && now_ - last_motion_ > milliseconds(watchdog_ms_)) {
      motors_on_ = false;
      watchdog_stopped_ = true;
      left_.goal = right_.goal = 0.0;
      say(Complaint{kWatchdog, "watchdog"}, now_);
    }
    if (report_ms_ > 0 && now_ >= next_report_) {
      next_report_ = std::max(next_report_ + milliseconds(report_ms_), now_);
      const auto ms = static_cast<uint32_t>((now_ - ready_).us / 1000);
      say(Report{ms, counted(left_.travelled - left_.counted_from),
                 counted(right_.travelled - right_.counted_from), flags()},
          now_);
    }
    if (options_.millivolts > 0 && report_ms_ > 0 && now_ >= next_battery_) {
      next_battery_ = now_ + kBatteryEvery;
      say(Battery{options_.millivolts}, now_);
    }
  }
}

void TextBoard::advance(Utime now, std::vector<uint8_t>& out) {
  run_until(now);
  output_.advance(now, out);
}

Utime TextBoard::next_event() const {
  return on_ ? std::min(now_ + kStep, output_.next_event()) : output_.next_event();
}

}  // namespace marco::drivers::textbase
