#include "drivers/textbase/driver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/transport/paced_output.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::textbase {
namespace {

constexpr double kFastestMPerS = 10.0;

// Counters of 32 bits wrap.
int32_t difference(uint32_t now, uint32_t before) { return static_cast<int32_t>(now - before); }

using Link = BaseStatus::Link;

// A boot loader that the opening of the port started listens so long, and takes what it hears for a
// program.
constexpr double kBootS = 2.0;
constexpr double kAskEveryS = 0.5;
constexpr int kWatchdogMs = 500;
constexpr int kReportMs = 20;

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

void ReportCounter::restart() {
  last_.reset();
  clock_.reset();
}

ReportCounter::Step ReportCounter::add(const Report& report, Utime left) {
  const Report before = last_.value_or(report);
  const int32_t since_ms = difference(report.board_ms, before.board_ms);
  if (since_ms < 0) return {.after_reset = true, .clicks = {}, .measured = {}};
  last_ = report;
  board_s_ += 1e-3 * since_ms;
  const int32_t left_ticks = difference(static_cast<uint32_t>(report.left_ticks),
                                        static_cast<uint32_t>(before.left_ticks));
  const int32_t right_ticks = difference(static_cast<uint32_t>(report.right_ticks),
                                         static_cast<uint32_t>(before.right_ticks));
  const double step_s = 1e-3 * std::max(since_ms, kLeastReportMs);
  const double most = kFastestMPerS * step_s / tick_m_;
  Step step;
  step.measured = clock_.update(board_s_, left);
  step.plausible = std::abs(static_cast<double>(left_ticks)) <= most &&
                   std::abs(static_cast<double>(right_ticks)) <= most;
  if (step.plausible) {
    step.clicks = {static_cast<double>(left_ticks), static_cast<double>(right_ticks),
                   left_ticks * tick_m_ / step_s, right_ticks * tick_m_ / step_s};
  }
  return step;
}

TextBase::TextBase(const TextBaseOptions& options)
    : DifferentialBase("textbase",
                       options.speeds,
                       options.guard,
                       std::numbers::pi * options.wheel_diameter_m / options.ticks_per_turn,
                       checked(options).track_m),
      reports_(tick_m()) {}

void TextBase::on_connection(bool connected, Utime now) {
  cutter_.clear();
  start_session(Phase::booting, now);
  ask_later(kBootS, now);
  note_line(connected, "the board", now);
}

void TextBase::start_session(Phase phase, Utime now) {
  begin_session(now);
  phase_ = phase;
  refused_ = has_sums_ = watchdog_set_ = reports_set_ = false;
  complaint_.clear();
  reports_.restart();
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
  note_sign_of_life(now);
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
  start_session(Phase::setting_up, now);
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
    if (phase_ == Phase::booting) start_session(Phase::asking, now);
    return;
  }
  if (refused_) return;
  const ReportCounter::Step step = reports_.add(report, now);
  if (step.after_reset) {
    start_session(Phase::asking, now);
    return set_link(Link::starting, "the board was reset", now);
  }
  if (!step.plausible) ++bad_lines_;
  turned(step.clicks, step.measured, now);
  judge(report.flags, now);
  follow_leg(now);
}

void TextBase::judge(unsigned flags, Utime now) {
  const bool motors_on = (flags & kMotorsOn) != 0;
  const bool switched = std::exchange(edit_status().motors_on, motors_on) != motors_on;
  const bool news =
      touched({(flags & kLeftBumper) != 0, (flags & kRightBumper) != 0}, now) || switched;
  if ((flags & kEmergencyStop) != 0) {
    set_link(Link::starting, "the board's emergency stop is pressed", now);
  } else if ((flags & kFault) != 0) {
    set_link(Link::starting, complaint_.empty() ? "the board reports a fault" : complaint_, now);
  } else if (watchdog_set_ && reports_set_ && status().link != Link::up) {
    phase_ = Phase::running;
    stand();
    set_link(Link::up, board_, now);
  } else if (news) {
    tell(now);
  }
}

void TextBase::ask(Utime now, std::vector<uint8_t>& out) {
  if (refused_ || !ask_is_due(kAskEveryS, now)) return;
  if (phase_ == Phase::booting) phase_ = Phase::asking;
  if (phase_ == Phase::asking) return send(WhoAreYou{}, out);
  if (!watchdog_set_) send(SetWatchdog{kWatchdogMs}, out);
  if (!reports_set_) send(SetReports{kReportMs}, out);
}

void TextBase::send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) {
  const auto ticks = [this](double m_per_s) {
    return static_cast<int>(std::lround(m_per_s / tick_m()));
  };
  if (due) send(Motion{ticks(speeds.left_m_per_s), ticks(speeds.right_m_per_s)}, out);
}

void TextBase::keep_link(Utime now, std::vector<uint8_t>& out) {
  const bool has_session = phase_ == Phase::setting_up || phase_ == Phase::running;
  const double patience_s = phase_ == Phase::running ? kSilentS : kSilentS + kAskEveryS;
  if (has_session && silent_for(patience_s, now)) {
    set_link(Link::down, "the board is silent", now);
    start_session(Phase::asking, now);
  }
  ask(now, out);
}

// A line half sent is ended first.
std::vector<uint8_t> TextBase::stop_bytes() const {
  std::vector<uint8_t> bytes{'\n'};
  send(Motion{}, bytes);
  return bytes;
}

}  // namespace marco::drivers::textbase
