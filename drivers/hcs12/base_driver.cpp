#include "drivers/hcs12/base_driver.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::hcs12 {
namespace {

using Link = BaseStatus::Link;

constexpr double kIdleStatusS = 0.1;
constexpr double kBatteryS = 10.0;
constexpr double kSonarS = 1.3;        // a round takes 1.2 s
constexpr double kSlowestPace = 1.25;  // of the board's ticks, as learn_pace believes
constexpr double kStallS = 0.1;        // between two calls: this process stood still

}  // namespace

Hcs12Base::Hcs12Base(const Hcs12BaseOptions& options)
    : BaseDriver("hcs12", options.speeds, options.guard), options_(options) {
  validate(options, "hcs12");
}

void Hcs12Base::on_connection(bool connected, Utime now) {
  connected_ = connected;
  exchange_.clear();
  if (run_ && run_->started) lost_run_ = run_;
  run_.reset();
  renewal_.reset();
  last_stamp_ = next_prediction_ = {};  // the host's clock may have been set back
  stop_asked_ = wait_armed_ = false;
  silent_ = 0;
  next_ping_ = now;
  set_link(Link::down, connected ? "waiting for the board" : "the line is gone", now);
}

void Hcs12Base::set_up(Utime now) {
  exchange_.clear_queue();
  exchange_.ask({encode_command('p'), 'p'});
  if (options_.sonar) {
    exchange_.ask({encode_command('s', {2, 50, 20}), 's'});
    exchange_.ask({encode_command('s', {1}), 's'});
  }
  next_battery_ = now;
  next_status_ = now;
  next_sonar_ = now + Duration::from_seconds(kSonarS);
  set_link(Link::up, "", now);
}

void Hcs12Base::on_reset(Utime now) {
  ++resets_;
  exchange_.clear();
  run_.reset();
  renewal_.reset();
  lost_run_.reset();
  stop_asked_ = wait_armed_ = false;
  set_link(Link::starting, "the board was reset", now);
  next_ping_ = now;
}

void Hcs12Base::note_time(Utime now) {
  if (run_ && std::abs((now - last_step_).seconds()) > kStallS) run_->stood_still = true;
  last_step_ = now;
}

void Hcs12Base::receive(std::span<const uint8_t> bytes, Utime now) {
  note_time(now);
  for (const std::string& line : exchange_.receive(bytes)) on_line(line, now);
}

void Hcs12Base::on_line(const std::string& line, Utime now) {
  if (sonar_.collecting() && exchange_.awaited() == 's') {
    const auto times = sonar_.push(line);
    if (times) {
      exchange_.answered();
      silent_ = 0;
      on_sonar(*times, now);
    } else if (!sonar_.collecting()) {
      ++bad_lines_;
      exchange_.answered();
    } else {
      exchange_.extend(now);
    }
    return;
  }
  if (line.rfind("Robot ", 0) == 0) return on_reset(now);
  if (line == "w" && wait_armed_) {
    wait_armed_ = false;
    silent_ = 0;
    if (run_) run_->rested_at = line_begun(line.size(), now);
    ask_status();
    return;
  }
  const char letter = line.empty() ? '\0' : line.front();
  if (letter == '\0' || letter != exchange_.awaited() || !on_reply(letter, line, now)) {
    ++bad_lines_;
    return;
  }
  silent_ = 0;
}

bool Hcs12Base::on_reply(char letter, const std::string& line, Utime now) {
  if (letter == 'l') {
    const auto status = parse_wheel_status(line);
    if (!status) return false;
    exchange_.answered();
    on_wheel_status(*status, line_begun(line.size(), now), now);
    return true;
  }
  if (letter == 't') {
    const auto batteries = parse_batteries(line);
    if (!batteries) return false;
    exchange_.answered();
    edit_status().battery_v.clear();
    for (const uint32_t millivolts : *batteries) {
      edit_status().battery_v.push_back(millivolts * 1e-3);
    }
    return true;
  }
  if (line.size() != 1) return false;
  exchange_.answered();
  if (run_ && renewal_ && letter == renewal_->letter) {
    take_over(line_begun(line.size(), now));
    return true;
  }
  if (run_ && letter == run_->letter && !run_->started) {
    run_->started = true;
    // The wheels have turned since the echo began to be printed.
    run_->started_at = run_->read_at = line_begun(line.size(), now);
    run_->progress_at = now;
    edit_status().motors_on = true;
    next_status_ = now + Duration::from_seconds(options_.poll_period_s);
    if (!run_->polled && !stop_asked_) ask_wait(now);
  }
  return true;
}

void Hcs12Base::ask_wait(Utime now) {
  // Four numbers: with the manual's three the firmware looks at no flags.
  wait_armed_ = true;
  RampWalk rest = run_->walk;
  while (!rest.done()) rest.tick();
  const int64_t ticks = rest.ticks() - run_->walk.ticks() + 600;
  const auto timer = static_cast<uint32_t>(std::min<int64_t>(ticks, 65000));
  exchange_.ask({encode_command('w', {timer, 1, 1, 0}), '\0'});
  wait_until_ = now + Duration::from_seconds(kSlowestPace * timer * kTickS + 1.0);
}

void Hcs12Base::on_sonar(const std::vector<uint32_t>& times, Utime now) {
  SonarRing ring;
  ring.utime = now;
  ring.cone_rad = deg_to_rad(options_.sonar_cone_deg);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double bearing = static_cast<double>(i) * 2.0 * std::numbers::pi / 16.0;
    const Pose2 robot_from_sonar{options_.sonar_ring_radius_m * std::cos(bearing),
                                 options_.sonar_ring_radius_m * std::sin(bearing),
                                 normalize_angle(bearing)};
    ring.readings.push_back(
        {sonar_range_m(times[i], options_.speed_of_sound_m_per_s), robot_from_sonar});
  }
  guard().on_sonar(ring, odom_from_robot(), now);
  output().sonar.push_back(std::move(ring));
}

void Hcs12Base::on_timeout(const LineExchange::Request& request, Utime now) {
  ++timeouts_;
  sonar_ = SonarCollector{};
  if (run_ && request.reply == run_->letter && !run_->started) {
    // Whether it set off nobody knows: stop, and let the counters tell what they can.
    run_->started = true;
    run_->started_at = run_->read_at = now - Duration::from_seconds(1.0);
    stop_wheels(now);
  }
  if (renewal_ && request.reply == renewal_->letter) {
    renewal_unanswered_ = true;
    stop_wheels(now);
  }
  if (++silent_ < 3) {
    // What can be said twice is; readings of the sonars come again by themselves.
    const bool repeatable = std::string("ltpks").find(request.reply) != std::string::npos &&
                            request.line != encode_command('s');
    if (repeatable) exchange_.ask_first(request);
    return;
  }
  exchange_.clear();
  if (run_ && run_->started) lost_run_ = run_;
  run_.reset();
  renewal_.reset();
  stop_asked_ = wait_armed_ = false;
  next_ping_ = now + Duration::from_seconds(kPingS);
  set_link(Link::down, "the board is silent", now);
}

void Hcs12Base::schedule(Utime now) {
  if (edit_status().link != Link::up) {
    if (now >= next_ping_ && exchange_.quiet()) {
      next_ping_ = now + Duration::from_seconds(kPingS);
      // Printing costs a board whose wheels turn fast some of its clicks.
      if (lost_run_) exchange_.ask({encode_command('p'), 'p'});
      exchange_.ask({encode_command('l'), 'l'});
    }
    return;
  }
  if (run_) {
    if (!run_->started || stop_asked_) return;
    if (wait_armed_ && now >= wait_until_) {  // its answer was lost, or the board is
      wait_armed_ = false;
      ++timeouts_;
      return ask_status();
    }
    if (run_->polled && now >= next_status_ && exchange_.quiet()) {
      next_status_ = now + Duration::from_seconds(options_.poll_period_s);
      ask_status();
    }
    const bool stuck = run_->polled && (now - run_->progress_at).seconds() > kStuckS;
    const bool overdue = !run_->polled && !wait_armed_ && exchange_.quiet();
    if ((stuck || overdue) && exchange_.quiet()) ask_stop();  // ends as a run that is over
    return;
  }
  if (!exchange_.quiet()) return;
  if (now >= next_status_) {
    next_status_ = now + Duration::from_seconds(kIdleStatusS);
    ask_status();
  } else if (now >= next_battery_) {
    next_battery_ = now + Duration::from_seconds(kBatteryS);
    exchange_.ask({encode_command('t'), 't'});
  } else if (options_.sonar && now >= next_sonar_ && idle()) {
    next_sonar_ = now + Duration::from_seconds(kSonarS);
    sonar_.begin(16);
    exchange_.ask({encode_command('s'), 's', 0.4});
  }
}

void Hcs12Base::advance(Utime now, std::vector<uint8_t>& out) {
  note_time(now);
  if (connected_) {
    follow_ramp(now);
    schedule(now);
  }
  advance_motion(now);
  if (!connected_) return;
  if (const auto late = exchange_.advance(now, out)) on_timeout(*late, now);
}

void Hcs12Base::shut_down(std::vector<uint8_t>& out) {
  // A line half sent is ended first.
  for (const char c : std::string_view("\np\n")) out.push_back(static_cast<uint8_t>(c));
}

}  // namespace marco::drivers::hcs12
