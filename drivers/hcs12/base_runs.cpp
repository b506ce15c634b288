// The runs of the base: pieces of legs, and those of a velocity, each following on the one before.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/hcs12/base_driver.hpp"

namespace marco::drivers::hcs12 {
namespace {

constexpr uint32_t kMaxTenths = 65535;
constexpr double kRenewAfterS = 0.6 * Hcs12Base::kVelocityRunS;
constexpr double kAcceleratedS = 0.3;  // of a run's beginning
// Of a run that follows on another at its speed: the board takes no step in it, neither faster (the
// listing gives the right wheel no top) nor slower.
constexpr uint32_t kNoStepTicks = 5000;

}  // namespace

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
  run.ramp = ramp_for(speed, speeds().acceleration_m_per_s2);
  const double piece = std::ceil(run.ramp.top * kLegRunS / kTickS / 100.0);
  run.tenths = static_cast<uint32_t>(std::min({tenths, piece, double{kMaxTenths}}));
  run.tenths_behind = static_cast<uint32_t>(tenths) - run.tenths;
  if (run.tenths == 0) return leg_ended(true, "", now);
  start_run(run, now);
}

void Hcs12Base::prepare(Run& run, double poll_limit_clicks, Utime now) {
  run.left_sign = run.letter == 'a' || run.letter == 'd' ? 1 : -1;
  run.right_sign = run.letter == 'a' || run.letter == 'i' ? 1 : -1;
  run.polled = run.ramp.top <= poll_limit_clicks;
  run.walk = RampWalk(run.ramp, run.tenths * 100, RampWalk::Brake::to_zero, RampWalk::Wheel::real);
  run.progress_at = now;
}

void Hcs12Base::start_run(Run run, Utime now) {
  prepare(run, options_.poll_limit_clicks, now);
  run_ = run;
  renewal_.reset();
  ask_ramp(run.ramp);
  exchange_.ask({encode_command(run.letter, {run.tenths}), run.letter});
}

void Hcs12Base::ask_ramp(const Ramp& ramp) {
  board_ramp_ = ramp;
  exchange_.ask({encode_command('k', {ramp.start, ramp.top, ramp.step_ticks}), 'k'});
}

void Hcs12Base::renew(Run next, Utime now) {
  const double driven_s = (now - run_->started_at).seconds();
  next.ramp.start = next.ramp.top;
  next.ramp.step_ticks = kNoStepTicks;
  const bool other_speed = differs(next, *run_);
  // Long before it is needed: each line that the board prints costs its controller some ticks, and
  // what the wheels turn between the last word of the counters and the new run must be guessed
  // well.
  if (board_ramp_ != next.ramp && (other_speed || driven_s > kAcceleratedS)) ask_ramp(next.ramp);
  if (driven_s < kRenewAfterS && !other_speed) return;
  prepare(next, options_.poll_limit_clicks, now);
  renewal_ = next;
  renewal_unanswered_ = false;
  ask_status();  // the counters begin again with the run
  exchange_.ask({encode_command(next.letter, {next.tenths}), next.letter});
}

// The wheels have not stood between the two runs. What they turned since the counters were read is
// known by their speed.
void Hcs12Base::take_over(Utime started) {
  const Run& old = *run_;
  const double since_s = std::clamp((started - old.read_at).seconds(), 0.0, kVelocityRunS);
  const double left = std::round(old.left_sign * old.left_clicks_per_s * since_s);
  const double right = std::round(old.right_sign * old.right_clicks_per_s * since_s);
  left_sum_ += static_cast<int64_t>(left);
  right_sum_ += static_cast<int64_t>(right);
  const double left_speed = old.left_sign * old.left_clicks_per_s * metres_per_click();
  const double right_speed = old.right_sign * old.right_clicks_per_s * metres_per_click();
  publish(started, left, right, (left_speed + right_speed) / 2.0,
          (right_speed - left_speed) / options_.track_m);
  run_ = std::exchange(renewal_, std::nullopt);
  run_->started = true;
  run_->started_at = run_->read_at = started;
  run_->progress_at = started;
}

double Hcs12Base::leg_remaining() const {
  if (!run_) return 0.0;
  const double passed = static_cast<double>(
      run_->polled ? run_->left_read : static_cast<uint32_t>(run_->walk.clicks()));
  const double clicks = std::max(0.0, (run_->tenths + run_->tenths_behind) * 100.0 - passed);
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
  run.of_velocity = true;
  run.ramp = ramp_for(wheel, 4.0 * speeds().acceleration_m_per_s2);
  run.ramp.top = std::min(run.ramp.top, static_cast<uint32_t>(options_.poll_limit_clicks));
  run.ramp.start = std::min(run.ramp.start, run.ramp.top);
  run.tenths = static_cast<uint32_t>(std::ceil(run.ramp.top * kVelocityRunS / kTickS / 100.0));
  if (!run_) return start_run(run, now);
  if (!run_->started || renewal_) return;
  if (run.letter != run_->letter) return stop_wheels(now);
  renew(run, now);
}

/// Enough to be worth a run of its own: the firmware cannot change the speed of one.
bool Hcs12Base::differs(const Run& wanted, const Run& driven) {
  const double top = wanted.ramp.top, old_top = driven.ramp.top;
  return top > 1.3 * old_top + 1.0 || top < 0.7 * old_top - 1.0;
}

void Hcs12Base::on_run_over(Utime now) {
  const Run run = *run_;
  if (renewal_) exchange_.clear_queue();  // too late: velocity mode starts again from rest
  renewal_.reset();
  if (stop_asked_) {
    stop_asked_ = false;
    run_.reset();
    stopped(now);
    return;
  }
  const int64_t missing =
      static_cast<int64_t>(run.tenths) * 100 - std::min(run.left_read, run.right_read);
  run_.reset();
  if (run.of_velocity) return;  // velocity mode starts it again where it wants
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
  if (missing <= 200 && run.tenths_behind > 0) return start_piece(run, now);
  leg_ended(missing <= 200, missing <= 200 ? "" : "the wheels did not get there", now);
}

/// The next piece of a long leg; what the last drove too far is taken off.
void Hcs12Base::start_piece(const Run& last, Utime now) {
  const int64_t too_far =
      (static_cast<int64_t>(last.left_read) + last.right_read) / 2 - last.tenths * int64_t{100};
  const int64_t tenths = std::max<int64_t>(
      0,
      last.tenths_behind - static_cast<int64_t>(std::lround(static_cast<double>(too_far) / 100)));
  const double piece = std::ceil(last.ramp.top * kLegRunS / kTickS / 100.0);
  Run next;
  next.letter = last.letter;
  next.ramp = last.ramp;
  next.tenths = static_cast<uint32_t>(std::min<double>(static_cast<double>(tenths), piece));
  next.tenths_behind = static_cast<uint32_t>(tenths) - next.tenths;
  if (next.tenths == 0) return leg_ended(true, "", now);
  start_run(next, now);
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

}  // namespace marco::drivers::hcs12
