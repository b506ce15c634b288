#include "drivers/textbase/driver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::textbase {
namespace {

using Link = BaseStatus::Link;

// A boot loader that the opening of the port started listens so long, and takes what it hears for a
// program.
constexpr double kBootS = 2.0;
constexpr double kAskEveryS = 0.5;
constexpr double kSilentS = 0.5;
constexpr int kWatchdogMs = 500;
constexpr int kReportMs = 20;

Duration seconds(double value) { return Duration::from_seconds(value); }

void send(const HostLine& line, std::vector<uint8_t>& out) {
  const std::string text = with_sum(encode(line)) + "\n";
  out.insert(out.end(), text.begin(), text.end());
}

const TextBaseOptions& checked(const TextBaseOptions& options) {
  validate(options, "textbase");
  require(options.ticks_per_turn > 0.0 && options.wheel_diameter_m > 0.0 && options.track_m > 0.0,
          "base.ticks_per_turn, base.wheel_diameter_m and base.track_m have no defaults: count the "
          "ticks of a wheel's turn, and measure the wheel and the way between the wheels");
  return options;
}

}  // namespace

TextBase::TextBase(const TextBaseOptions& options)
    : BaseDriver("textbase", options.speeds, options.guard),
      options_(checked(options)),
      odometry_(tick_m(), options.track_m),
      plan_(tick_m(), options.track_m) {
  TextBase::speeds_changed();
}

double TextBase::tick_m() const {
  return std::numbers::pi * options_.wheel_diameter_m / options_.ticks_per_turn;
}

void TextBase::speeds_changed() { plan_.set_speeds(speeds()); }

void TextBase::on_connection(bool connected, Utime now) {
  connected_ = connected;
  cutter_.clear();
  begin_session(Phase::booting, now);
  next_ask_ = now + seconds(kBootS);
  set_link(Link::down, connected ? "waiting for the board" : "the line is gone", now);
}

void TextBase::begin_session(Phase phase, Utime now) {
  phase_ = phase;
  next_ask_ = understood_ = now;
  refused_ = has_sums_ = watchdog_set_ = reports_set_ = false;
  complaint_.clear();
  odometry_.restart();
  plan_.stand();
}

void TextBase::receive(std::span<const uint8_t> bytes, Utime now) {
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto line = cutter_.push(bytes[i]);
    if (line && !line->empty()) on_line(*line, now - line_time(bytes.size() - 1 - i, kBaud));
  }
}

void TextBase::on_line(const std::string& line, Utime now) {
  const auto body = without_sum(line);
  const auto parsed = body ? parse_board_line(body->text) : std::nullopt;
  // A board that has just started does not know yet that its host has sums.
  const bool may_lack_sum = parsed && (!has_sums_ || std::holds_alternative<Hello>(*parsed));
  if (!parsed || (!body->had_sum && !may_lack_sum)) {
    ++bad_lines_;
    return;
  }
  has_sums_ = body->had_sum;
  understood_ = now;
  if (const auto* hello = std::get_if<Hello>(&*parsed)) on_hello(*hello, now);
  if (const auto* done = std::get_if<Done>(&*parsed)) {
    watchdog_set_ = watchdog_set_ || *done == Done{'W', kWatchdogMs};
    reports_set_ = reports_set_ || *done == Done{'R', kReportMs};
  }
  if (const auto* battery = std::get_if<Battery>(&*parsed)) {
    edit_status().battery_v = {1e-3 * battery->millivolts};
  }
  if (const auto* complaint = std::get_if<Complaint>(&*parsed)) on_complaint(*complaint, now);
  if (const auto* report = std::get_if<Report>(&*parsed)) {
    on_report(*report, now - line_time(line.size() + 1, kBaud));
  }
}

// Also unasked, when the board has just started.
void TextBase::on_hello(const Hello& hello, Utime now) {
  board_ = hello.name + " " + hello.firmware;
  begin_session(Phase::setting_up, now);
  refused_ = hello.protocol > kProtocol;
  const std::string protocol = " speaks protocol " + std::to_string(hello.protocol);
  set_link(Link::starting, refused_ ? board_ + protocol + ", newer than this driver" : board_, now);
}

void TextBase::on_complaint(const Complaint& complaint, Utime now) {
  if (complaint.number <= kBadValue) {
    ++bad_lines_;  // the line to the board is bad
  } else if (complaint.number != kWatchdog) {
    complaint_ = complaint.text;
    if (status().link != Link::down) set_link(status().link, complaint_, now);
  }
}

void TextBase::on_report(const Report& report, Utime now) {
  if (phase_ == Phase::booting || phase_ == Phase::asking) {
    // It speaks, so no boot loader listens.
    if (phase_ == Phase::booting) begin_session(Phase::asking, now);
    return;
  }
  if (refused_) return;
  const ReportOdometry::Step step = odometry_.add(report, now);
  if (step.after_reset) {
    begin_session(Phase::asking, now);
    return set_link(Link::starting, "the board was reset", now);
  }
  if (!step.plausible) ++bad_lines_;
  plan_.note_motion(step.moved);
  const Pose2 before = odom_from_robot();
  publish_odometry(step.sample);
  judge_link(report.flags, now);
  if (const auto end = plan_.follow(before, odom_from_robot(), step.moved, now)) {
    leg_ended(end->reached, end->why_not, now);
  }
}

void TextBase::judge_link(unsigned flags, Utime now) {
  const bool left = (flags & kLeftBumper) != 0, right = (flags & kRightBumper) != 0;
  std::vector<int> pressed;
  if (left) pressed.push_back(1);
  if (right) pressed.push_back(2);
  guard().on_bumpers(pressed, {});
  if (!pressed.empty() && plan_.velocity_m_per_s() > 0.0) {  // a ramp would push on
    plan_.cut_velocity();
    next_motion_ = now;
  }
  const std::vector<bool> bumpers{left, right};
  const bool motors_on = (flags & kMotorsOn) != 0;
  const bool news = bumpers != edit_status().bumpers || motors_on != edit_status().motors_on;
  edit_status().bumpers = bumpers;
  edit_status().motors_on = motors_on;
  if ((flags & kEmergencyStop) != 0) {
    set_link(Link::starting, "the board's emergency stop is pressed", now);
  } else if ((flags & kFault) != 0) {
    set_link(Link::starting, complaint_.empty() ? "the board reports a fault" : complaint_, now);
  } else if (watchdog_set_ && reports_set_ && status().link != Link::up) {
    phase_ = Phase::running;
    plan_.stand();
    set_link(Link::up, board_, now);
  } else if (news) {
    tell(now);
  }
}

void TextBase::start_leg(const Leg& leg, Utime now) {
  plan_.start_leg(leg, odom_from_robot(), now);
}

double TextBase::leg_remaining() const { return plan_.leg_remaining(odom_from_robot()); }

void TextBase::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime /*now*/) {
  plan_.drive(velocity_m_per_s, yaw_rate_rad_per_s);
}

void TextBase::stop_wheels(Utime /*now*/) { plan_.stop(); }

void TextBase::emergency_brake(Utime now) {
  stop_wheels(now);
  plan_.halt();
  next_motion_ = now;
}

Motion TextBase::wheel_speeds() const {
  const auto ticks = [this](double m_per_s) {
    return static_cast<int>(std::lround(m_per_s / tick_m()));
  };
  return {ticks(plan_.left_m_per_s()), ticks(plan_.right_m_per_s())};
}

void TextBase::ask(Utime now, std::vector<uint8_t>& out) {
  if (now < next_ask_ || refused_) return;
  next_ask_ = now + seconds(kAskEveryS);
  if (phase_ == Phase::booting) phase_ = Phase::asking;
  if (phase_ == Phase::asking) return send(WhoAreYou{}, out);
  if (!watchdog_set_) send(SetWatchdog{kWatchdogMs}, out);
  if (!reports_set_) send(SetReports{kReportMs}, out);
}

void TextBase::send_motion(Utime now, std::vector<uint8_t>& out) {
  if (phase_ != Phase::running || now < next_motion_) return;
  next_motion_ = now + seconds(WheelPlan::kStepS);
  if (status().link == Link::up) {
    plan_.step(odom_from_robot());
  } else {
    plan_.halt();
  }
  send(wheel_speeds(), out);
}

void TextBase::advance(Utime now, std::vector<uint8_t>& out) {
  if (!connected_) return;
  const bool has_session = phase_ == Phase::setting_up || phase_ == Phase::running;
  const double patience_s = phase_ == Phase::running ? kSilentS : kSilentS + kAskEveryS;
  if (has_session && (now - understood_).seconds() > patience_s) {
    set_link(Link::down, "the board is silent", now);
    begin_session(Phase::asking, now);
  }
  ask(now, out);
  advance_motion(now);
  if (plan_.came_to_stand()) stopped(now);
  send_motion(now, out);
}

// A line half sent is ended first.
std::vector<uint8_t> TextBase::stop_bytes() const {
  std::vector<uint8_t> bytes{'\n'};
  send(Motion{}, bytes);
  return bytes;
}

}  // namespace marco::drivers::textbase
