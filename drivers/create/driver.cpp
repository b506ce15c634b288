#include "drivers/create/driver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::create {
namespace {

using Link = BaseStatus::Link;

constexpr double kSilentS = 0.5;
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
    : BaseDriver("create", options.speeds, options.guard),
      options_(checked(options)),
      search_(options.baud > 0 ? options.baud : kBaud,
              options.baud > 0 ? std::vector<int>{} : std::vector<int>{19'200, 57'600}),
      odometry_(tick_m(), options.track_m),
      counters_(tick_m()),
      plan_(tick_m(), options.track_m) {
  CreateBase::speeds_changed();
}

double CreateBase::tick_m() const {
  return std::numbers::pi * options_.wheel_diameter_m / kTicksPerTurn;
}

void CreateBase::on_connection(bool connected, Utime now) {
  connected_ = connected;
  parser_.clear();
  speed_due_ = heard_ ? search_.current() : search_.next();
  next_speed_ = now + seconds(kEachSpeedS);
  begin_session(now);
  set_link(Link::down, connected ? "waiting for the robot" : "the line is gone", now);
}

void CreateBase::begin_session(Utime now) {
  streams_ = false;
  safe_due_ = may_be_safe_ = true;
  asked_since_ = next_ask_ = understood_ = now;
  last_left_.reset();
  counters_.forget();
  odometry_.forget_stamps();
  plan_.stand();
}

void CreateBase::receive(std::span<const uint8_t> bytes, Utime now) {
  parser_.push(bytes);
  while (const auto received = parser_.next()) {
    on_sensors(received->sensors, now - line_time(received->bytes_after, search_.current()));
  }
}

void CreateBase::on_sensors(const Sensors& sensors, Utime left) {
  understood_ = left;
  streams_ = heard_ = true;
  const Pose2 before = odom_from_robot();
  const bool moved = count(sensors, left);
  plan_.note_motion(moved);
  judge_bumpers(sensors, left);
  judge_link(sensors, left);
  if (const auto end = plan_.follow(before, odom_from_robot(), moved, left)) {
    leg_ended(end->reached, end->why_not, left);
  }
}

/// @returns whether the wheels turned.
bool CreateBase::count(const Sensors& sensors, Utime left) {
  // Frames may arrive in bursts.
  const double step_s = std::max(kStreamS, last_left_ ? (left - *last_left_).seconds() : 0.0);
  last_left_ = left;
  const auto step = counters_.count(sensors.left_ticks, sensors.right_ticks, step_s);
  publish_odometry(odometry_.count(step, left));
  return step.left_clicks != 0.0 || step.right_clicks != 0.0;
}

void CreateBase::judge_bumpers(const Sensors& sensors, Utime now) {
  std::vector<int> pressed;
  if (sensors.left_bump) pressed.push_back(1);
  if (sensors.right_bump) pressed.push_back(2);
  guard().on_bumpers(pressed, {});
  if (!pressed.empty() && plan_.velocity_m_per_s() > 0.0) {  // a ramp would push on
    plan_.cut_velocity();
    next_motion_ = now;
  }
  edit_status().battery_v = {1e-3 * sensors.millivolts};
  const std::vector<bool> bumpers{sensors.left_bump, sensors.right_bump};
  const bool news = bumpers != edit_status().bumpers;
  edit_status().bumpers = bumpers;
  if (news) tell(now);
}

std::string CreateBase::why_unsafe(const Sensors& sensors) {
  if (sensors.wheel_drop()) return "a wheel hangs: is the robot lifted?";
  if (sensors.cliff()) return "there is a cliff in front of it: push it back";
  return sensors.charges() ? "it charges: take it off its charger" : "";
}

// Safe mode ends by itself at a cliff, a hanging wheel or a charger, and is asked for again when
// the cause is gone; firmware that says its mode one too high never says "passive". Nothing that
// was ordered before resumes.
void CreateBase::judge_link(const Sensors& sensors, Utime now) {
  std::string why_not = why_unsafe(sensors);
  const bool unsafe = !why_not.empty();
  safe_due_ = safe_due_ || unsafe;
  may_be_safe_ = !unsafe;
  if (!unsafe && sensors.mode < static_cast<int>(OiMode::safe)) {
    safe_due_ = true;
    why_not = "it is not in its mode 'safe'";
  }
  if (why_not.empty() && safe_due_) return;
  edit_status().motors_on = why_not.empty();
  if (!why_not.empty()) {
    if (status().link == Link::starting && status().note == why_not) return;
    plan_.stand();
    set_link(Link::starting, why_not, now);
  } else if (status().link != Link::up) {
    plan_.stand();
    set_link(Link::up, "Create 2 or Roomba", now);
  }
}

void CreateBase::start_leg(const Leg& leg, Utime now) {
  plan_.start_leg(leg, odom_from_robot(), now);
}

void CreateBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime /*now*/) {
  plan_.drive(velocity_m_per_s, yaw_rate_rad_per_s);
}

void CreateBase::emergency_brake(Utime now) {
  plan_.stop();
  plan_.halt();
  next_motion_ = now;
}

void CreateBase::ask(Utime now, std::vector<uint8_t>& out) {
  const bool asks_for_safe = safe_due_ && may_be_safe_;
  if (now < next_ask_ || (streams_ && !asks_for_safe)) return;
  next_ask_ = now + seconds(kAskEveryS);
  // START stops the wheels and makes it listen; without it nothing is answered.
  if (!streams_) {
    append(out, encode_request(Opcode::start));
    append(out, stream_request());
  }
  append(out, encode_request(Opcode::safe));
  safe_due_ = false;
}

void CreateBase::send_motion(Utime now, std::vector<uint8_t>& out) {
  if (!streams_ || now < next_motion_) return;
  next_motion_ = now + seconds(WheelPlan::kStepS);
  if (status().link != Link::up) return plan_.halt();
  plan_.step(odom_from_robot());
  const auto mm_per_s = [](double m_per_s) {
    return std::clamp(static_cast<int>(std::lround(1e3 * m_per_s)), -kMostMmPerS, kMostMmPerS);
  };
  append(out, drive_request(mm_per_s(plan_.left_m_per_s()), mm_per_s(plan_.right_m_per_s())));
}

void CreateBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  if (streams_ && (now - understood_).seconds() > kSilentS) {
    // Perhaps it still hears us: START stops its wheels.
    begin_session(now);
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
  advance_motion(now);
  if (plan_.came_to_stand()) stopped(now);
  send_motion(now, out);
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
