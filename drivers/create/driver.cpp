#include "drivers/create/driver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::create {
namespace {

using Link = BaseStatus::Link;

constexpr double kAskEveryS = 0.5;
constexpr double kEachSpeedS = 1.4;  // asked three times
constexpr double kPatienceS = 4.5;   // then it sleeps

Duration seconds(double value) { return Duration::from_seconds(value); }

void append(std::vector<uint8_t>& out, const Bytes& bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

const CreateOptions& checked(const CreateOptions& options) {
  validate(options, "create");
  require(
      options.baud == 0 || options.baud == 115'200 || options.baud == 57'600 ||
          options.baud == 19'200,
      "create.baud is 0 (searched), 115200, 57600 or 19200, not " + std::to_string(options.baud));
  return options;
}

}  // namespace

CreateBase::CreateBase(const CreateOptions& options)
    : DifferentialBase("create",
                       options.speeds,
                       options.guard,
                       std::numbers::pi * options.wheel_diameter_m / kTicksPerTurn,
                       checked(options).track_m),
      search_(options.baud > 0 ? options.baud : kBaud,
              options.baud > 0 ? std::vector<int>{} : std::vector<int>{19'200, 57'600}),
      counters_(tick_m()) {}

void CreateBase::on_connection(bool connected, Utime now) {
  parser_.clear();
  speed_due_ = heard_ ? search_.current() : search_.next();
  next_speed_ = now + seconds(kEachSpeedS);
  start_session(now);
  note_line(connected, "the robot", now);
}

void CreateBase::start_session(Utime now) {
  begin_session(now);
  streams_ = false;
  safe_due_ = may_be_safe_ = true;
  asked_since_ = now;
  last_left_.reset();
  counters_.forget();
}

void CreateBase::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (const auto received = parser_.next()) {
    on_sensors(received->sensors, now - line_time(received->bytes_after, search_.current()));
  }
}

void CreateBase::on_sensors(const Sensors& sensors, Utime left) {
  note_sign_of_life(left);
  streams_ = heard_ = true;
  count(sensors, left);
  edit_status().battery_v = {1e-3 * sensors.millivolts};
  if (touched({sensors.left_bump, sensors.right_bump}, left)) tell(left);
  judge(sensors, left);
  follow_leg(left);
}

void CreateBase::count(const Sensors& sensors, Utime left) {
  // Frames may arrive in bursts.
  const double step_s = std::max(kStreamS, last_left_ ? (left - *last_left_).seconds() : 0.0);
  last_left_ = left;
  turned(counters_.count(sensors.left_ticks, sensors.right_ticks, step_s), left, left);
}

std::string CreateBase::why_unsafe(const Sensors& sensors) {
  if (sensors.wheel_drop()) return "a wheel hangs: is the robot lifted?";
  if (sensors.cliff()) return "there is a cliff in front of it: push it back";
  return sensors.charges() ? "it charges: take it off its charger" : "";
}

// Safe mode ends by itself at a cliff, a hanging wheel or a charger, and is asked for again when
// the cause is gone; firmware that says its mode one too high never says "passive". Nothing that
// was ordered before resumes.
void CreateBase::judge(const Sensors& sensors, Utime now) {
  std::string why_not = why_unsafe(sensors);
  may_be_safe_ = why_not.empty();
  safe_due_ = safe_due_ || !may_be_safe_;
  if (may_be_safe_ && sensors.mode < static_cast<int>(OiMode::safe)) {
    safe_due_ = true;
    why_not = "it is not in its mode 'safe'";
  }
  if (!why_not.empty() || !safe_due_) judge_link(why_not, "Create 2 or Roomba", now);
}

void CreateBase::ask(Utime now, std::vector<uint8_t>& out) {
  const bool asks_for_safe = safe_due_ && may_be_safe_;
  if ((streams_ && !asks_for_safe) || !ask_is_due(kAskEveryS, now)) return;
  // START stops the wheels and makes it listen; without it nothing is answered.
  if (!streams_) {
    append(out, encode_request(Opcode::start));
    append(out, stream_request());
  }
  append(out, encode_request(Opcode::safe));
  safe_due_ = false;
}

void CreateBase::send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) {
  if (!due || status().link != Link::up) return;
  const auto mm_per_s = [](double m_per_s) {
    return std::clamp(static_cast<int>(std::lround(1e3 * m_per_s)), -kMostMmPerS, kMostMmPerS);
  };
  append(out, drive_request(mm_per_s(speeds.left_m_per_s), mm_per_s(speeds.right_m_per_s)));
}

void CreateBase::keep_link(Utime now, std::vector<uint8_t>& out) {
  if (streams_ && silent_for(kSilentS, now)) {
    // It may still receive: START stops its wheels.
    start_session(now);
    set_link(Link::down, "the robot is silent", now);
  }
  if (!heard_ && now > next_speed_) {
    next_speed_ = now + seconds(kEachSpeedS);
    speed_due_ = search_.next();
    parser_.clear();
  }
  const std::string asleep = "the robot does not answer: press CLEAN to wake it";
  if (!streams_ && (now - asked_since_).seconds() > kPatienceS && status().note != asleep) {
    set_link(Link::down, asleep, now);
  }
  ask(now, out);
}

// The zeros end the longest request that was sent in part; the robot passes over those left.
std::vector<uint8_t> CreateBase::stop_bytes() const {
  std::vector<uint8_t> bytes(stream_request().size() - 1, 0);
  append(bytes, drive_request(0, 0));
  return bytes;
}

void CreateBase::shut_down(std::vector<uint8_t>& out) {
  BaseDriver::shut_down(out);
  append(out, encode_request(Opcode::start));
  append(out, encode_request(Opcode::stop));
}

}  // namespace marco::drivers::create
