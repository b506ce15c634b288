#include "drivers/hcs12/run_control.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

constexpr double kRenewAfterS = 0.6 * kVelocityRunS;
constexpr double kAcceleratedS = 0.3;  // of a run's beginning
// A run that follows another at its speed must not be accelerated: the listing gives the right
// wheel no top.
constexpr uint32_t kNoStepTicks = 5000;
constexpr double kPredictionPeriodS = 0.05;
constexpr double kStallS = 0.1;         // between two calls: this process stood still
constexpr int64_t kMissedClicks = 200;  // a run that ends this far from its goal has missed it

}  // namespace

void BoardCommands::stop() {
  exchange_.clear_queue();
  exchange_.ask({encode_command('p'), 'p'});
  status();
}

void BoardCommands::ramp_if_new(const Ramp& wanted) {
  if (ramp_ != wanted) ramp(wanted);
}

void BoardCommands::ramp(const Ramp& wanted) {
  ramp_ = wanted;
  exchange_.ask({encode_command('k', {wanted.start, wanted.top, wanted.step_ticks}), 'k'});
}

void BoardCommands::run(const RunOrder& order) {
  exchange_.ask({encode_command(order.letter, {order.tenths}), order.letter});
}

void BoardCommands::wait_for_rest(const RampWalk& walk, Utime now) {
  constexpr double kSlowestPace = 1.25;  // of the board's ticks, as RunControl believes
  RampWalk rest = walk;
  rest.finish();
  const int64_t ticks = rest.ticks() - walk.ticks() + 600;
  const auto timer = static_cast<uint32_t>(std::min<int64_t>(ticks, 65000));
  // Four numbers: with the manual's three the firmware looks at no flags.
  exchange_.ask({encode_command('w', {timer, 1, 1, 0}), '\0'});
  wait_until_ = now + Duration::from_seconds(kSlowestPace * timer * kTickS + 1.0);
}

bool BoardCommands::give_up_wait(Utime now) {
  if (!wait_until_ || now < *wait_until_) return false;
  wait_until_.reset();
  ++lost_waits_;
  status();
  return true;
}

bool BoardCommands::poll(Utime now, double period_s) {
  if (now < next_status_ || !quiet()) return false;
  next_status_ = now + Duration::from_seconds(period_s);
  status();
  return true;
}

RunControl::RunControl(const Hcs12BaseOptions& options, LineExchange& exchange, Publish publish)
    : options_(options),
      commands_(exchange),
      odometry_(options.metres_per_click(), options.track_m),
      publish_(std::move(publish)) {}

double RunControl::metres_per_s(double clicks_per_tick) const {
  return clicks_per_tick * options_.metres_per_click() / kTickS;
}

void RunControl::note_time(Utime now) {
  if (run_ && std::abs((now - last_step_).seconds()) > kStallS) run_->stood_still = true;
  last_step_ = now;
}

void RunControl::forget_stamps() {
  odometry_.forget_stamps();
  next_prediction_ = {};
}

void RunControl::abandon() {
  if (run_ && run_->started) lost_run_ = run_;
  run_.reset();
  renewal_.reset();
  stop_asked_ = false;
  commands_.end_wait();
}

void RunControl::forget() {
  abandon();
  lost_run_.reset();
}

// The board was ordered to stop; its counters hold the distance driven meanwhile. The next status
// is waited for: what the driver asks for while it sets up the board comes first.
void RunControl::take_up_lost_run(Utime now) {
  if (!lost_run_) return;
  constexpr double kLongAgoS = 60.0;
  run_ = std::exchange(lost_run_, std::nullopt);
  run_->started_at = now - Duration::from_seconds(kLongAgoS);
  run_->reading.progress_at = now;
  run_->order.of_velocity = true;
  stop_asked_ = true;
  commands_.status();
}

bool RunControl::start_leg(const BaseDriver::Leg& leg, const BaseSpeeds& speeds, Utime now) {
  const RunOrder order = RunOrder::of_leg(leg, speeds, options_);
  if (order.tenths == 0) return false;
  start(order, now);
  return true;
}

void RunControl::start(const RunOrder& order, Utime now) {
  run_.emplace(order, options_.poll_limit_clicks, now);
  renewal_.reset();
  commands_.ramp(order.ramp);
  commands_.run(order);
}

void RunControl::drive(double velocity_m_per_s,
                       double yaw_rate_rad_per_s,
                       const BaseSpeeds& speeds,
                       Utime now) {
  if (stop_asked_) return;  // first the wheels come to rest
  const auto order =
      RunOrder::of_velocity_command(velocity_m_per_s, yaw_rate_rad_per_s, speeds, options_);
  if (!order) {
    if (run_) stop();
    return;
  }
  if (!run_) return start(*order, now);
  if (!run_->started || renewal_) return;
  if (order->letter != run_->order.letter) return stop();
  renew(*order, now);
}

// A run of nearly that speed continues as it is.
BaseVelocity RunControl::as_driven(const BaseVelocity& order, const BaseSpeeds& speeds) const {
  const auto run =
      RunOrder::of_velocity_command(order.ahead_m_per_s, order.turn_rad_per_s, speeds, options_);
  if (!run) return {};
  const bool goes_on =
      run_ && run_->order.letter == run->letter && !run->differs_in_speed(run_->order);
  const double wheel = metres_per_s(std::max(run->ramp.top, goes_on ? run_->order.ramp.top : 0U));
  const WheelSigns signs = wheel_signs(run->letter).value();
  if (signs.left == signs.right) return {signs.left * wheel, 0.0};
  return {0.0, signs.right * wheel / (options_.track_m / 2.0)};
}

void RunControl::renew(RunOrder next, Utime now) {
  const double driven_s = (now - run_->started_at).seconds();
  next.ramp.start = next.ramp.top;
  next.ramp.step_ticks = kNoStepTicks;
  const bool other_speed = next.differs_in_speed(run_->order);
  // Long before it is needed: each line that the board prints costs its controller some ticks, and
  // what the wheels turn between the last reading and the new run must be guessed well.
  if (other_speed || driven_s > kAcceleratedS) commands_.ramp_if_new(next.ramp);
  if (driven_s < kRenewAfterS && !other_speed) return;
  renewal_.emplace(next, options_.poll_limit_clicks, now);
  commands_.status();  // the counters begin again with the run
  commands_.run(next);
}

// The wheels have not stood between the two runs. What they turned since the counters were read is
// known by their speed.
void RunControl::take_over(Utime begun) {
  const DriveRun::Clicks clicks = run_->extrapolated(begun);
  const DriveRun::Clicks per_s = run_->clicks_per_s();
  publish_(odometry_.count({clicks.left, clicks.right, per_s.left * options_.metres_per_click(),
                            per_s.right * options_.metres_per_click()},
                           begun));
  run_ = std::exchange(renewal_, std::nullopt);
  run_->begin(begun, begun);
}

void RunControl::stop() {
  stop_asked_ = true;
  // A renewal that has been sent begins before it is stopped.
  if (renewal_ && commands_.awaited() != renewal_->order.letter) renewal_.reset();
  commands_.stop();
}

double RunControl::leg_remaining() const {
  if (!run_) return 0.0;
  const double way_m = run_->remaining_clicks() * options_.metres_per_click();
  if (run_->order.letter == 'i') return way_m / (options_.track_m / 2.0);
  if (run_->order.letter == 'd') return -way_m / (options_.track_m / 2.0);
  return run_->order.letter == 'a' ? way_m : -way_m;
}

bool RunControl::on_echo(char letter, Utime begun, Utime now) {
  if (run_ && renewal_ && letter == renewal_->order.letter) {
    take_over(begun);
    return false;
  }
  if (!run_ || letter != run_->order.letter || run_->started) return false;
  run_->begin(begun, now);  // the wheels have turned since the echo began to be printed
  commands_.poll_at(now + Duration::from_seconds(options_.poll_period_s));
  if (!run_->polled && !stop_asked_) commands_.wait_for_rest(run_->walk, now);
  return true;
}

bool RunControl::on_wait_answer(Utime begun) {
  if (!commands_.waits()) return false;
  commands_.end_wait();
  if (run_) run_->rested_at = begun;
  commands_.status();
  return true;
}

void RunControl::on_timeout(const LineExchange::Request& request, Utime now) {
  if (run_ && request.reply == run_->order.letter && !run_->started) {
    // Nobody knows whether it set off: stop, and let the counters tell what they can.
    run_->begin(now - Duration::from_seconds(1.0), run_->reading.progress_at);
    stop();
  }
  if (renewal_ && request.reply == renewal_->order.letter) stop();
}

RunControl::Event RunControl::on_wheel_status(const WheelStatus& status,
                                              Utime measured,
                                              Utime now) {
  const bool still = !status.left_on && !status.right_on;
  if (!run_ || !run_->started) return on_status_at_rest(still, measured);
  // What no wheel can have done is not believed, unless it is reported three times.
  if (!run_->is_plausible(status, measured)) {
    if (++implausible_ >= 3) return Event::counters_restarted;  // without a banner
    commands_.status_first();
    return Event::implausible;
  }
  implausible_ = 0;
  const DriveRun::Clicks clicks = run_->read(status, measured, now);
  const double speed = still ? 0.0 : metres_per_s(run_->order.ramp.top);
  publish_(odometry_.count(
      {clicks.left, clicks.right, run_->signs.left * speed, run_->signs.right * speed}, measured));
  if (still) return on_run_over(now);
  if (stop_asked_) {
    commands_.stop();  // `p` was lost
  } else if (!run_->polled) {
    // The first `w` ended by its timer; wheels that stand by now have crept to rest.
    if (run_->moves(now)) {
      commands_.wait_for_rest(run_->walk, now);
    } else {
      commands_.stop();
    }
  }
  return Event::none;
}

RunControl::Event RunControl::on_status_at_rest(bool still, Utime measured) {
  if (stop_asked_) run_.reset();  // it never set off
  publish_(odometry_.count({}, measured));
  if (!stop_asked_) return Event::none;
  if (!still) {
    commands_.stop();
    return Event::none;
  }
  stop_asked_ = false;
  return Event::stopped;
}

RunControl::Event RunControl::on_run_over(Utime now) {
  const DriveRun run = *run_;
  if (renewal_) commands_.clear_queue();  // too late: velocity mode starts again from rest
  renewal_.reset();
  run_.reset();
  if (std::exchange(stop_asked_, false)) return Event::stopped;
  if (run.order.of_velocity) return Event::none;  // velocity mode starts again where it wants
  if (run.missing_clicks() > kMissedClicks) {
    if (run.retries >= 3) return Event::leg_missed;
    start(run.rest(), now);
    run_->retries = run.retries + 1;
    run_->stood_still = run.stood_still;
    return Event::none;
  }
  if (const auto pace = run.pace()) pace_ = std::clamp(0.5 * (pace_ + *pace), 0.8, 1.25);
  if (run.order.tenths_behind == 0) return Event::leg_reached;
  const RunOrder next = run.next_piece();
  if (next.tenths == 0) return Event::leg_reached;
  start(next, now);
  return Event::none;
}

void RunControl::follow_ramp(Utime now) {
  if (!run_ || !run_->started) return;
  run_->walk.advance_to(
      static_cast<int64_t>(pace_ * static_cast<double>((now - run_->started_at).us) / kTickUs));
  if (run_->polled || stop_asked_ || now < next_prediction_) return;
  next_prediction_ = now + Duration::from_seconds(kPredictionPeriodS);
  const DriveRun::Clicks clicks = run_->walked();
  const double speed = metres_per_s(static_cast<double>(run_->walk.speed()));
  publish_(odometry_.predict(
      {clicks.left, clicks.right, run_->signs.left * speed, run_->signs.right * speed}, now));
}

bool RunControl::schedule(Utime now) {
  if (!run_) return false;
  if (!run_->started || stop_asked_ || commands_.give_up_wait(now)) return true;
  if (run_->polled) commands_.poll(now, options_.poll_period_s);
  const bool over = run_->polled ? !run_->moves(now) : !commands_.waits();
  if (over && commands_.quiet()) commands_.stop();  // ends as a run that has come to rest
  return true;
}

}  // namespace marco::drivers::hcs12
