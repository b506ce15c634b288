#include "drivers/hcs12/base_driver.hpp"

#include <cmath>

namespace marco::drivers::hcs12 {
namespace {

using Link = BaseStatus::Link;

constexpr double kIdleStatusS = 0.1;
constexpr double kBatteryS = 10.0;
constexpr double kSonarS = 1.3;  // a round takes 1.2 s

}  // namespace

Hcs12Base::Hcs12Base(const Hcs12BaseOptions& options)
    : BaseDriver("hcs12", options.speeds, options.guard),
      options_(options),
      runs_(
          options_, exchange_, [this](const OdometrySample& sample) { publish_odometry(sample); }) {
  validate(options, "hcs12");
}

void Hcs12Base::on_connection(bool connected, Utime now) {
  exchange_.on_connection(connected, now);
  runs_.abandon();
  runs_.forget_stamps();
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
  runs_.commands().poll_at(now);
  next_sonar_ = now + Duration::from_seconds(kSonarS);
  set_link(Link::up, "", now);
}

void Hcs12Base::on_reset(Utime now) {
  ++resets_;
  exchange_.clear();
  runs_.forget();
  set_link(Link::starting, "the board was reset", now);
  exchange_.ping_at(now);
}

void Hcs12Base::receive(std::span<const uint8_t> bytes, Utime now) {
  runs_.note_time(now);
  for (const std::string& line : exchange_.receive(bytes)) on_line(line, now);
}

void Hcs12Base::on_line(const std::string& line, Utime now) {
  if (sonar_.collecting() && exchange_.awaited() == 's') return on_sonar_line(line, now);
  if (line.rfind("Robot ", 0) == 0) return on_reset(now);
  if (line == "w" && runs_.on_wait_answer(line_begun(line.size(), now))) return exchange_.accept();
  const char letter = line.empty() ? '\0' : line.front();
  if (letter == '\0' || letter != exchange_.awaited() || !on_reply(letter, line, now)) {
    return exchange_.reject();
  }
  exchange_.accept();
}

void Hcs12Base::on_sonar_line(const std::string& line, Utime now) {
  if (const auto times = sonar_.push(line)) {
    exchange_.answered();
    exchange_.accept();
    on_sonar(*times, now);
  } else if (!sonar_.collecting()) {
    exchange_.reject();
    exchange_.answered();
  } else {
    exchange_.extend(now);
  }
}

bool Hcs12Base::on_reply(char letter, const std::string& line, Utime now) {
  const Utime begun = line_begun(line.size(), now);
  if (letter == 'l') {
    const auto status = parse_wheel_status(line);
    if (!status) return false;
    exchange_.answered();
    on_wheel_status(*status, begun, now);
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
  if (runs_.on_echo(letter, begun, now)) edit_status().motors_on = true;
  return true;
}

void Hcs12Base::on_wheel_status(const WheelStatus& status, Utime measured, Utime now) {
  using Event = RunControl::Event;
  if (edit_status().link != Link::up) {
    set_up(now);
    return runs_.take_up_lost_run(now);
  }
  const Event event = runs_.on_wheel_status(status, measured, now);
  if (event == Event::implausible) return exchange_.reject();
  if (event == Event::counters_restarted) return on_reset(now);
  edit_status().motors_on = status.left_on || status.right_on;
  if (event == Event::stopped) stopped(now);
  if (event == Event::leg_reached) leg_ended(true, "", now);
  if (event == Event::leg_missed) leg_ended(false, "the wheels did not reach the goal", now);
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
  guard().on_sonar(ring, odom_from_robot(), now, Surroundings::Sonars::at_rest);
  output().sonar.push_back(std::move(ring));
}

void Hcs12Base::on_timeout(const LineExchange::Request& request, Utime now) {
  ++timeouts_;
  sonar_ = SonarCollector{};
  runs_.on_timeout(request, now);
  if (!exchange_.is_silent_after_timeout()) {
    // Motion commands must not be sent twice. The sonars are read again by themselves.
    const bool repeatable = std::string("ltpks").find(request.reply) != std::string::npos &&
                            request.line != encode_command('s');
    if (repeatable) exchange_.ask_first(request);
    return;
  }
  exchange_.clear();
  runs_.abandon();
  exchange_.ping_later(now);
  set_link(Link::down, "the board is silent", now);
}

void Hcs12Base::schedule(Utime now) {
  if (edit_status().link != Link::up) {
    if (!exchange_.ping_due(now)) return;
    // Printing costs a board whose wheels turn fast some of its clicks: it is stopped first.
    if (runs_.has_lost_run()) exchange_.ask({encode_command('p'), 'p'});
    return runs_.commands().status();
  }
  if (runs_.schedule(now) || !exchange_.quiet()) return;
  if (runs_.commands().poll(now, kIdleStatusS)) return;
  if (now >= next_battery_) {
    next_battery_ = now + Duration::from_seconds(kBatteryS);
    exchange_.ask({encode_command('t'), 't'});
  } else if (options_.sonar && now >= next_sonar_ && idle()) {
    next_sonar_ = now + Duration::from_seconds(kSonarS);
    sonar_.begin(16);
    exchange_.ask({encode_command('s'), 's', 0.4});
  }
}

void Hcs12Base::advance(Utime now, std::vector<uint8_t>& out) {
  runs_.note_time(now);
  if (exchange_.connected()) {
    runs_.follow_ramp(now);
    schedule(now);
  }
  advance_motion(now);
  if (!exchange_.connected()) return;
  if (const auto late = exchange_.advance(now, out)) on_timeout(*late, now);
}

void Hcs12Base::start_leg(const Leg& leg, Utime now) {
  if (!runs_.start_leg(leg, speeds(), now)) leg_ended(true, "", now);
}

void Hcs12Base::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) {
  runs_.drive(velocity_m_per_s, yaw_rate_rad_per_s, speeds(), now);
}

// `p` brakes at once, and a run begins at its speed.
BaseDynamics Hcs12Base::dynamics() const {
  constexpr double kAtOnce = 100.0;  // m/s2
  const double turn = kAtOnce / (options_.track_m / 2.0);
  return {kAtOnce, kAtOnce, turn, turn};
}

}  // namespace marco::drivers::hcs12
