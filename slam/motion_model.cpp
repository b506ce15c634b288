#include "slam/motion_model.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

double square(double value) { return value * value; }

}  // namespace

MotionModel::MotionModel(const MotionOptions& options) : options_(options) {
  validate(options, "motion");
}

MotionGuess MotionModel::from_odometry(const Pose2& step) const {
  const double distance_m = std::hypot(step.x_m, step.y_m);
  const double turn_deg = std::abs(rad_to_deg(step.theta_rad));
  const double sigma_m = std::hypot(options_.sigma_floor_m, options_.sigma_per_m * distance_m);
  const double sigma_deg = options_.sigma_floor_deg + options_.sigma_deg_per_m * distance_m +
                           options_.sigma_deg_per_deg * turn_deg;
  MotionGuess guess;
  guess.source = MotionGuess::Source::odometry;
  guess.before_from_now = step;
  guess.covariance =
      Eigen::Vector3d(square(sigma_m), square(sigma_m), square(deg_to_rad(sigma_deg))).asDiagonal();
  return guess;
}

MotionGuess MotionModel::from_velocity(double dt_s) const {
  const double dt = std::clamp(dt_s, 0.0, options_.max_gap_s);
  MotionGuess guess;
  guess.source = velocity_known_ && dt_s >= 0.0 && dt_s <= options_.max_gap_s
                     ? MotionGuess::Source::velocity
                     : MotionGuess::Source::nothing;
  if (guess.source == MotionGuess::Source::velocity) guess.before_from_now = velocity_.after(dt);
  // The velocity may change at once and then stay: a step of acceleration * dt over dt.
  const double sigma_m = options_.sigma_floor_m + options_.acceleration_m_per_s2 * dt * dt;
  const double sigma_deg =
      options_.sigma_floor_deg + options_.turn_acceleration_deg_per_s2 * dt * dt;
  guess.covariance =
      Eigen::Vector3d(square(sigma_m), square(sigma_m), square(deg_to_rad(sigma_deg))).asDiagonal();
  return guess;
}

MotionGuess MotionModel::guess(const MotionInput& now) const {
  if (!before_) return {};
  const double dt_s = (now.utime - before_->utime).seconds();
  MotionGuess guess = from_velocity(dt_s);
  if (now.odom_from_robot && before_->odom_from_robot) {
    const Pose2 step = between(*before_->odom_from_robot, *now.odom_from_robot);
    const double limit_m = std::max(options_.max_step_m, options_.max_speed_m_per_s * dt_s);
    if (std::hypot(step.x_m, step.y_m) <= limit_m) guess = from_odometry(step);
  }
  if (guess.source == MotionGuess::Source::odometry && period_s_ > 0.0) {
    const double periods = std::abs(lag_s(dt_s) - before_lag_s_) / period_s_;
    // Where odometry goes on as it did of late, it came with the scan and does not mind the stamp.
    const Pose2& step = guess.before_from_now;
    const double off_m =
        std::min(periods * move_m_, std::abs(std::hypot(step.x_m, step.y_m) - move_m_));
    const double off_rad =
        std::min(periods * turn_rad_, std::abs(std::abs(step.theta_rad) - turn_rad_));
    guess.covariance(0, 0) += square(off_m);
    guess.covariance(1, 1) += square(off_m);
    guess.covariance(2, 2) += square(off_rad);
  }
  if (now.gyro_heading_rad && before_->gyro_heading_rad) {
    const double sigma_rad = deg_to_rad(0.1 + options_.gyro_sigma_deg_per_s * std::abs(dt_s));
    if (square(sigma_rad) < guess.covariance(2, 2)) {
      guess.before_from_now.theta_rad =
          normalize_angle(*now.gyro_heading_rad - *before_->gyro_heading_rad);
      guess.covariance(2, 2) = square(sigma_rad);
    }
  }
  return guess;
}

double MotionModel::lag_s(double dt_s) const {
  constexpr double kMostPeriods = 10.0;
  return std::clamp(before_lag_s_ + period_s_ - dt_s, 0.0, kMostPeriods * period_s_);
}

void MotionModel::learn_rhythm(double dt_s, const Pose2& step) {
  // The median of a stream, by small steps towards each value (Tierney 1983).
  constexpr double kMedianStep = 0.05;
  if (dt_s > 0.0 && period_s_ == 0.0) period_s_ = dt_s;
  before_lag_s_ = lag_s(dt_s);
  if (period_s_ > 0.0) period_s_ *= dt_s > period_s_ ? 1.0 + kMedianStep : 1.0 - kMedianStep;
  constexpr double kFresh = 0.3;
  move_m_ += kFresh * (std::hypot(step.x_m, step.y_m) - move_m_);
  turn_rad_ += kFresh * (std::abs(step.theta_rad) - turn_rad_);
}

void MotionModel::update(const MotionInput& now, const Pose2& before_from_now) {
  if (before_) {
    learn_rhythm((now.utime - before_->utime).seconds(), before_from_now);
    history_.push_back({before_->utime, Pose2{}});
    for (Step& step : history_) step.then_from_now = step.then_from_now * before_from_now;
  }
  before_ = now;
  measure_velocity();
}

void MotionModel::restore(const MotionState& state) {
  before_ = state.before;
  history_ = state.history;
  period_s_ = state.period_s;
  before_lag_s_ = state.before_lag_s;
  move_m_ = state.move_m;
  turn_rad_ = state.turn_rad;
  velocity_ = Velocity2{};
  velocity_known_ = false;
  if (before_) measure_velocity();
}

void MotionModel::measure_velocity() {
  const auto age_s = [this](const Step& step) { return (before_->utime - step.utime).seconds(); };
  // The youngest step that is old enough; a clock that went backwards starts anew.
  while (history_.size() > 1 && age_s(history_[1]) >= options_.velocity_span_s) {
    history_.pop_front();
  }
  while (!history_.empty() &&
         (age_s(history_.front()) > options_.max_gap_s || age_s(history_.front()) < 0.0)) {
    history_.pop_front();
  }
  velocity_ = Velocity2{};
  velocity_known_ = false;
  if (history_.empty()) return;
  const double dt_s = age_s(history_.front());
  const Pose2& moved = history_.front().then_from_now;
  const double limit_rad_per_s = deg_to_rad(options_.max_turn_rate_deg_per_s);
  if (dt_s < 1e-3 || moved.translation_m().norm() > options_.max_speed_m_per_s * dt_s ||
      std::abs(moved.theta_rad) > limit_rad_per_s * dt_s) {
    return;
  }
  velocity_known_ = true;
  // The inverse of Velocity2::after to first order in the turn.
  const Pose2 chord = Pose2{0, 0, -0.5 * moved.theta_rad} * moved;
  velocity_ = {chord.x_m / dt_s, chord.y_m / dt_s, moved.theta_rad / dt_s};
}

}  // namespace marco::slam
