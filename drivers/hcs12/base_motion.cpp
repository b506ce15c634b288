// How the base moves and what its wheels say: legs, velocities, odometry.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/hcs12/base_driver.hpp"

namespace marco::drivers::hcs12 {
namespace {

using Link = BaseStatus::Link;
constexpr double kBasePredictionS = 0.05;
constexpr uint32_t kMaxTenths = 65535;
constexpr uint32_t kMaxClicksPerTick = 90;

}  // namespace

double Hcs12Base::metres_per_click() const {
  return std::numbers::pi * options_.wheel_diameter_m / options_.clicks_per_wheel_turn;
}

uint32_t Hcs12Base::clicks_per_tick(double wheel_m_per_s) const {
  const double clicks = std::round(std::abs(wheel_m_per_s) / metres_per_click() * kTickS);
  return static_cast<uint32_t>(std::clamp(clicks, 2.0, double{kMaxClicksPerTick}));
}

Ramp Hcs12Base::ramp_for(double wheel_m_per_s, double wheel_m_per_s2) const {
  Ramp ramp;
  ramp.top = clicks_per_tick(wheel_m_per_s);
  ramp.start = std::min<uint32_t>(5, ramp.top);
  const double clicks_per_tick2 = wheel_m_per_s2 / metres_per_click() * kTickS * kTickS;
  ramp.step_ticks = static_cast<uint32_t>(std::clamp(1.0 / clicks_per_tick2 - 1.0, 1.0, 1000.0));
  return ramp;
}

double Hcs12Base::stop_distance_m() const {
  return 0.03 + 0.2 * speeds().velocity_m_per_s;  // `p` brakes at once; the way is that of the line
}

void Hcs12Base::start_leg(const Leg& leg, Utime now) {
  const bool turns = leg.kind == Leg::Kind::turn;
  const double way_m = turns ? leg.amount * options_.track_m / 2.0 : leg.amount;
  const double speed =
      turns ? speeds().yaw_rate_rad_per_s * options_.track_m / 2.0 : speeds().velocity_m_per_s;
  const double tenths = std::round(std::abs(way_m) / metres_per_click() / 100.0);
  Run run;
  run.letter = turns ? (way_m > 0.0 ? 'i' : 'd') : (way_m > 0.0 ? 'a' : 'r');
  run.tenths = static_cast<uint32_t>(std::min(tenths, double{kMaxTenths}));
  run.ramp = ramp_for(speed, speeds().acceleration_m_per_s2);
  if (run.tenths == 0) return leg_ended(true, "", now);
  start_run(run, now);
}

void Hcs12Base::start_run(Run run, Utime now) {
  run.left_sign = run.letter == 'a' || run.letter == 'd' ? 1 : -1;
  run.right_sign = run.letter == 'a' || run.letter == 'i' ? 1 : -1;
  run.polled = run.ramp.top <= options_.poll_limit_clicks;
  run.walk = RampWalk(run.ramp, run.tenths * 100, RampWalk::Brake::to_zero, RampWalk::Wheel::real);
  run.progress_at = now;
  run_ = run;
  exchange_.ask({encode_command('k', {run.ramp.start, run.ramp.top, run.ramp.step_ticks}), 'k'});
  exchange_.ask({encode_command(run.letter, {run.tenths}), run.letter});
}

double Hcs12Base::leg_remaining() const {
  if (!run_) return 0.0;
  const double passed = static_cast<double>(
      run_->polled ? run_->left_read : static_cast<uint32_t>(run_->walk.clicks()));
  const double clicks = std::max(0.0, run_->tenths * 100.0 - passed);
  const double way_m = clicks * metres_per_click();
  if (run_->letter == 'i') return way_m / (options_.track_m / 2.0);
  if (run_->letter == 'd') return -way_m / (options_.track_m / 2.0);
  return run_->letter == 'a' ? way_m : -way_m;
}

void Hcs12Base::drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) {
  const double spin = yaw_rate_rad_per_s * options_.track_m / 2.0;
  const bool turns = std::abs(spin) > std::abs(velocity_m_per_s);
  const double wheel = std::clamp(turns ? spin : velocity_m_per_s, -options_.velocity_limit_m_per_s,
                                  options_.velocity_limit_m_per_s);
  if (stop_asked_) return;  // first comes to rest
  if (std::abs(wheel) < 0.01) {
    if (run_) stop_wheels(now);
    return;
  }
  Run run;
  run.letter = turns ? (wheel > 0.0 ? 'i' : 'd') : (wheel > 0.0 ? 'a' : 'r');
  run.tenths = kMaxTenths;
  run.endless = true;
  run.ramp = ramp_for(wheel, 4.0 * speeds().acceleration_m_per_s2);
  run.ramp.top = std::min(run.ramp.top, static_cast<uint32_t>(options_.poll_limit_clicks));
  run.ramp.start = std::min(run.ramp.start, run.ramp.top);
  if (!run_) return start_run(run, now);
  // The firmware cannot change the speed of a run for good: stop and start anew, but not for less
  // than a noticeable difference.
  const double top = run.ramp.top, old_top = run_->ramp.top;
  if (run.letter != run_->letter || top > 1.3 * old_top + 1.0 || top < 0.7 * old_top - 1.0) {
    stop_wheels(now);
  }
}

void Hcs12Base::ask_status(bool first) {
  LineExchange::Request request{encode_command('l'), 'l'};
  if (first) {
    exchange_.ask_first(request);
  } else {
    exchange_.ask(request);
  }
}

void Hcs12Base::ask_stop() {
  exchange_.clear_queue();
  exchange_.ask({encode_command('p'), 'p'});
  ask_status();
}

void Hcs12Base::stop_wheels(Utime /*now*/) {
  stop_asked_ = true;
  ask_stop();
}

void Hcs12Base::on_wheel_status(const WheelStatus& status, Utime measured, Utime now) {
  if (edit_status().link != Link::up) {
    set_up(now);
    return take_up_lost_run(now);
  }
  const bool still = !status.left_on && !status.right_on;
  if (!run_ || !run_->started) {
    if (run_ && stop_asked_) run_.reset();  // it never set off
    edit_status().motors_on = !still;
    publish(measured, 0.0, 0.0, 0.0, 0.0);
    if (!stop_asked_) return;
    if (!still) return ask_stop();
    stop_asked_ = false;
    return stopped(now);
  }
  Run& run = *run_;
  // There is no checksum: what no wheel can have done is not believed, unless it is said thrice.
  const double passed_s = std::max(0.0, (measured - run.started_at).seconds()) + 0.1;
  const double most = (kMaxClicksPerTick + 20) * passed_s / kTickS;
  const bool plausible = status.left_clicks >= run.left_read &&
                         status.right_clicks >= run.right_read && status.left_clicks <= most &&
                         status.right_clicks <= most;
  if (!plausible && ++implausible_ < 3) {
    ++bad_lines_;
    ask_status(true);
    return;
  }
  if (!plausible) return on_reset(now);  // the counters began anew without a banner
  implausible_ = 0;
  const double left = run.left_sign * static_cast<double>(status.left_clicks - run.left_read);
  const double right = run.right_sign * static_cast<double>(status.right_clicks - run.right_read);
  if (left != 0.0 || right != 0.0) run.progress_at = now;
  run.left_read = status.left_clicks;
  run.right_read = status.right_clicks;
  const double speed = still ? 0.0 : run.ramp.top * metres_per_click() / kTickS;
  const double v = speed * (run.left_sign + run.right_sign) / 2.0;
  const double w = speed * (run.right_sign - run.left_sign) / options_.track_m;
  left_sum_ += static_cast<int64_t>(left);
  right_sum_ += static_cast<int64_t>(right);
  edit_status().motors_on = !still;
  publish(measured, left, right, v, w);
  if (still) return on_run_over(now);
  if (stop_asked_) return ask_stop();  // `p` was lost
  if (run.polled) return;
  // The first `w` ended by its timer; wheels that stand by now have crept to rest.
  if ((now - run.progress_at).seconds() > kStuckS) return ask_stop();
  ask_wait(now);
}

// It has been told to stop; what it drove meanwhile its counters know. The next status is waited
// for, since what was asked for by set_up() comes first.
void Hcs12Base::take_up_lost_run(Utime now) {
  if (!lost_run_) return;
  constexpr double kLongAgoS = 60.0;
  run_ = std::exchange(lost_run_, std::nullopt);
  run_->started_at = now - Duration::from_seconds(kLongAgoS);
  run_->progress_at = now;
  run_->endless = true;
  stop_asked_ = true;
  ask_status();
}

void Hcs12Base::on_run_over(Utime now) {
  const Run run = *run_;
  if (stop_asked_) {
    stop_asked_ = false;
    run_.reset();
    stopped(now);
    return;
  }
  const int64_t missing =
      static_cast<int64_t>(run.tenths) * 100 - std::min(run.left_read, run.right_read);
  run_.reset();
  if (run.endless) return;  // velocity mode starts it again where it wants
  if (missing <= 200) learn_pace(run);
  if (missing > 200 && run.retries < 3) {
    // It crept to rest before its goal (the brake has no floor): the rest is a move of its own.
    Run rest = run;
    rest.tenths = static_cast<uint32_t>(missing / 100);
    rest.started = false;
    rest.left_read = rest.right_read = 0;
    rest.retries = run.retries + 1;
    return start_run(rest, now);
  }
  leg_ended(missing <= 200, missing <= 200 ? "" : "the wheels did not get there", now);
}

void Hcs12Base::learn_pace(const Run& run) {
  constexpr double kLeastTicks = 1000.0;
  const double real_ticks = static_cast<double>((run.rested_at - run.started_at).us) / kTickUs;
  if (run.polled || run.stood_still || real_ticks < kLeastTicks) return;
  RampWalk walk(run.ramp, run.tenths * 100, RampWalk::Brake::to_zero, RampWalk::Wheel::real);
  while (!walk.done()) walk.tick();
  const double pace = static_cast<double>(walk.ticks()) / real_ticks;
  pace_ = std::clamp(0.5 * (pace_ + pace), 0.8, 1.25);
}

void Hcs12Base::publish(
    Utime measured, double left_clicks, double right_clicks, double v, double w) {
  const double left_m = left_clicks * metres_per_click();
  const double right_m = right_clicks * metres_per_click();
  const double way_m = (left_m + right_m) / 2.0;
  const double turn_rad = (right_m - left_m) / options_.track_m;
  // Along the chord of the arc.
  counted_pose_ = counted_pose_ * Pose2{way_m * std::cos(turn_rad / 2.0),
                                        way_m * std::sin(turn_rad / 2.0), turn_rad};
  OdometrySample sample;
  sample.utime = later_stamp(measured);
  sample.odom_from_robot = counted_pose_;
  sample.velocity_m_per_s = v;
  sample.yaw_rate_rad_per_s = w;
  sample.left_clicks = left_sum_;
  sample.right_clicks = right_sum_;
  publish_odometry(sample);
}

Utime Hcs12Base::later_stamp(Utime stamp) {
  // A counted pose is as old as its line; predictions may have been told since.
  last_stamp_ = std::max(stamp, last_stamp_ + Duration::from_us(1));
  return last_stamp_;
}

void Hcs12Base::follow_ramp(Utime now) {
  if (!run_ || !run_->started) return;
  Run& run = *run_;
  const auto ticks =
      static_cast<int64_t>(pace_ * static_cast<double>((now - run.started_at).us) / kTickUs);
  while (run.walk.ticks() < ticks && !run.walk.done()) run.walk.tick();
  if (run.polled || stop_asked_ || now < next_prediction_) return;
  next_prediction_ = now + Duration::from_seconds(kBasePredictionS);
  const double clicks =
      static_cast<double>(std::min<int64_t>(run.walk.clicks(), run.tenths * int64_t{100}));
  const double way = clicks - static_cast<double>(run.left_read);
  const double ahead_m = way * metres_per_click() * (run.left_sign + run.right_sign) / 2.0;
  const double turn =
      way * metres_per_click() * (run.right_sign - run.left_sign) / options_.track_m;
  const double speed = static_cast<double>(run.walk.speed()) * metres_per_click() / kTickS;
  OdometrySample sample;
  sample.utime = later_stamp(now);
  sample.odom_from_robot = counted_pose_ * Pose2{ahead_m, 0.0, turn};
  sample.velocity_m_per_s = speed * (run.left_sign + run.right_sign) / 2.0;
  sample.yaw_rate_rad_per_s = speed * (run.right_sign - run.left_sign) / options_.track_m;
  sample.left_clicks = left_sum_ + static_cast<int64_t>(run.left_sign * way);
  sample.right_clicks = right_sum_ + static_cast<int64_t>(run.right_sign * way);
  publish_odometry(sample);
}

}  // namespace marco::drivers::hcs12
