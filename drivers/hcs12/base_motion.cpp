// What the wheels say: counters, odometry, and when the base has come to rest.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/hcs12/base_driver.hpp"

namespace marco::drivers::hcs12 {
namespace {

using Link = BaseStatus::Link;
constexpr double kBasePredictionS = 0.05;

}  // namespace

double Hcs12Base::metres_per_click() const {
  return std::numbers::pi * options_.wheel_diameter_m / options_.clicks_per_wheel_turn;
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
  // A renewal that has been sent begins before it is stopped.
  if (renewal_ && exchange_.awaited() != renewal_->letter) renewal_.reset();
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
  if (renewal_ && renewal_unanswered_ && status.left_clicks < run_->left_read) {
    take_over(run_->read_at);
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
  if (const double since_s = (measured - run.read_at).seconds(); since_s > 0.02) {
    run.left_clicks_per_s = std::abs(left) / since_s;
    run.right_clicks_per_s = std::abs(right) / since_s;
  }
  run.read_at = measured;
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
  run_->of_velocity = true;
  stop_asked_ = true;
  ask_status();
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
