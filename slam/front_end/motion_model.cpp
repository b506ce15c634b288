#include "slam/front_end/motion_model.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// What the scans that lag must agree on before it is believed.
constexpr int kSureVotes = 3;

double square(double value) { return value * value; }

// Over a single scan, a velocity that straightens scans which take as long feeds back without end.
constexpr double kCalmPeriods = 1.8;

// A turn counts as the way of a point so far off.
constexpr double kArmM = 0.5;

double distance(const Pose2& a, const Pose2& b) {
  const Pose2 off = between(a, b);
  return std::hypot(off.x_m, off.y_m) + kArmM * std::abs(off.theta_rad);
}

Pose2 part_of(const Pose2& step, double part) {
  return {part * step.x_m, part * step.y_m, part * step.theta_rad};
}

}  // namespace

std::optional<Velocity2> believed_velocity(const Pose2& moved,
                                           double dt_s,
                                           const MotionOptions& options) {
  const double limit_rad_per_s = deg_to_rad(options.max_turn_rate_deg_per_s);
  if (dt_s < 1e-3 || moved.translation_m().norm() > options.max_speed_m_per_s * dt_s ||
      std::abs(moved.theta_rad) > limit_rad_per_s * dt_s) {
    return std::nullopt;
  }
  return velocity_of(moved, dt_s);
}

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

MotionGuess MotionModel::from_last_step() const {
  MotionGuess guess = from_odometry(last_step_);
  const double more_m = options_.acceleration_m_per_s2 * square(period_s_);
  guess.covariance(0, 0) += square(more_m);
  guess.covariance(1, 1) += square(more_m);
  guess.covariance(2, 2) +=
      square(deg_to_rad(options_.turn_acceleration_deg_per_s2) * square(period_s_));
  return guess;
}

bool MotionModel::came_with_scan(const Pose2& step, double dt_s, bool lagging) const {
  if (std::abs(came_with_scan_) >= kSureVotes) return came_with_scan_ > 0;
  return lagging && distance(step, last_step_) <= distance(step, part_of(last_step_, pace(dt_s)));
}

void MotionModel::learn_origin(const Pose2& step, const Pose2& matched, double dt_s) {
  constexpr double kClear = 0.02;
  const double off_scan = distance(step, matched);
  const double off_stamp = distance(step, part_of(matched, pace(dt_s)));
  if (std::abs(off_scan - off_stamp) < kClear) return;
  came_with_scan_ = std::clamp(came_with_scan_ + (off_scan < off_stamp ? 1 : -1), -3 * kSureVotes,
                               3 * kSureVotes);
}

void MotionModel::learn_step(const MotionInput& now) {
  last_step_ = Pose2{};
  if (!anchor_ || !anchor_->odom_from_robot || !now.odom_from_robot) return;
  const Pose2 way = between(*anchor_->odom_from_robot, *now.odom_from_robot);
  if (std::hypot(way.x_m, way.y_m) > options_.max_step_m) return;
  const double since_s = (now.utime - anchor_->utime).seconds();
  const double scans = period_s_ > 0.0 ? std::max(1.0, std::round(since_s / period_s_)) : 1.0;
  const double turn = way.theta_rad / scans;
  const Pose2 chord = Pose2{0, 0, -0.5 * way.theta_rad} * way;
  const Pose2 ahead = Pose2{0, 0, 0.5 * turn} * Pose2{chord.x_m / scans, chord.y_m / scans, 0};
  last_step_ = {ahead.x_m, ahead.y_m, turn};
}

double MotionModel::pace(double dt_s) const { return std::clamp(dt_s / period_s_, -1.0, 1.0); }

void MotionModel::doubt_stamp(const Pose2& step, double dt_s, MotionGuess& guess) const {
  const double periods = std::abs(lag_s(dt_s) - before_lag_s_) / period_s_;
  const double off_m =
      std::min(periods * move_m_, std::abs(std::hypot(step.x_m, step.y_m) - move_m_));
  const double off_rad =
      std::min(periods * turn_rad_, std::abs(std::abs(step.theta_rad) - turn_rad_));
  guess.covariance(0, 0) += square(off_m);
  guess.covariance(1, 1) += square(off_m);
  guess.covariance(2, 2) += square(off_rad);
}

void MotionModel::doubt_leap(double dt_s, MotionGuess& guess) const {
  const double passed_s = std::max(dt_s, period_s_);
  if (period_s_ <= 0.0 || believed_velocity(guess.before_from_now, passed_s, options_)) return;
  const Pose2 off = between(velocity_.after(passed_s), guess.before_from_now);
  guess.covariance.diagonal() +=
      Eigen::Vector3d(square(off.x_m), square(off.y_m), square(off.theta_rad));
}

void MotionModel::heed_gyro(const MotionInput& now, MotionGuess& guess) const {
  if (!now.gyro_heading_rad || !anchor_ || !anchor_->gyro_heading_rad) return;
  const double since_s = (now.utime - anchor_->utime).seconds();
  const double sigma_rad = deg_to_rad(0.1 + options_.gyro_sigma_deg_per_s * std::abs(since_s));
  if (square(sigma_rad) >= guess.covariance(2, 2)) return;
  guess.before_from_now.theta_rad = normalize_angle(
      *now.gyro_heading_rad - *anchor_->gyro_heading_rad - anchor_from_before_.theta_rad);
  guess.covariance(2, 2) = square(sigma_rad);
}

MotionGuess MotionModel::guess(const MotionInput& now) const {
  if (!before_) return {};
  const double dt_s = (now.utime - before_->utime).seconds();
  MotionGuess guess = from_velocity(dt_s);
  const bool lagging = lags(dt_s);
  if (now.odom_from_robot && before_->odom_from_robot && anchor_ && anchor_->odom_from_robot) {
    const Pose2 way = between(*anchor_->odom_from_robot, *now.odom_from_robot);
    const double since_s = (now.utime - anchor_->utime).seconds();
    const double limit_m = std::max(options_.max_step_m, options_.max_speed_m_per_s * since_s);
    if (std::hypot(way.x_m, way.y_m) <= limit_m) {
      const Pose2 step = between(*before_->odom_from_robot, *now.odom_from_robot);
      if (came_with_scan(step, dt_s, lagging)) {
        guess = from_odometry(step);
        if (period_s_ > 0.0) doubt_stamp(step, dt_s, guess);
      } else if (lagging) {
        guess = from_last_step();
      } else {
        guess = from_odometry(way);
        guess.before_from_now = between(anchor_from_before_, way);
      }
      doubt_leap(dt_s, guess);
    }
  }
  if (!lagging) heed_gyro(now, guess);
  return guess;
}

bool MotionModel::stands_still(const MotionInput& now) const {
  // Less than wheels can tell; and what matches of a standing robot differ by.
  constexpr double kNoStepM = 5e-4, kNoTurnDeg = 0.03, kCalmM = 5e-3, kCalmDeg = 0.3;
  if (!before_ || !before_->odom_from_robot || !now.odom_from_robot) return false;
  const Pose2 step = between(*before_->odom_from_robot, *now.odom_from_robot);
  return std::hypot(step.x_m, step.y_m) <= kNoStepM &&
         std::abs(step.theta_rad) <= deg_to_rad(kNoTurnDeg) &&
         !lags((now.utime - before_->utime).seconds()) && move_m_ <= kCalmM &&
         turn_rad_ <= deg_to_rad(kCalmDeg);
}

bool MotionModel::leaps(const Pose2& moved, Utime now) const {
  // Stamps in bursts hide a few scans' way; in that time a robot drives no farther.
  constexpr double kM = 0.3, kDeg = 30.0;
  if (!before_) return false;
  const double since_s = std::abs((now - before_->utime).seconds());
  return moved.translation_m().norm() > kM + since_s * options_.max_speed_m_per_s ||
         std::abs(moved.theta_rad) > deg_to_rad(kDeg + since_s * options_.max_turn_rate_deg_per_s);
}

bool MotionModel::lags(double dt_s) const {
  // A stamp's jitter; and a rhythm that so many scans do not keep is none.
  constexpr double kPart = 0.3;
  constexpr int kMost = 8;
  return period_s_ > 0.0 && lagging_ < kMost && lag_s(dt_s) > kPart * period_s_;
}

double MotionModel::lag_s(double dt_s) const {
  constexpr double kMostPeriods = 10.0;
  return std::clamp(before_lag_s_ + period_s_ - dt_s, 0.0, kMostPeriods * period_s_);
}

void MotionModel::learn_rhythm(double dt_s, const Pose2& step) {
  // The median of a stream, by small steps towards each value (Tierney 1983), and smaller ones
  // where it is near: stamps that jitter must not make the rhythm err by more than they do.
  constexpr double kMedianStep = 0.05, kPartOfWay = 0.5;
  if (dt_s > 0.0 && period_s_ == 0.0) period_s_ = dt_s;
  before_lag_s_ = lag_s(dt_s);
  const double most_s = kMedianStep * period_s_;
  period_s_ += std::clamp(kPartOfWay * (dt_s - period_s_), -most_s, most_s);
  constexpr double kFresh = 0.3;
  move_m_ += kFresh * (std::hypot(step.x_m, step.y_m) - move_m_);
  turn_rad_ += kFresh * (std::abs(step.theta_rad) - turn_rad_);
}

void MotionModel::update(const MotionInput& now, const Pose2& before_from_now) {
  const bool lagging = before_ && lags((now.utime - before_->utime).seconds());
  if (before_) anchor_from_before_ = anchor_from_before_ * before_from_now;
  const bool spoke = before_ && before_->odom_from_robot.has_value();
  if (lagging && spoke == now.odom_from_robot.has_value()) {
    if (spoke) {
      learn_origin(between(*before_->odom_from_robot, *now.odom_from_robot), before_from_now,
                   (now.utime - before_->utime).seconds());
    }
    ++lagging_;
  } else {
    learn_step(now);
    anchor_ = now;
    anchor_from_before_ = Pose2{};
    lagging_ = 0;
  }
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
  anchor_ = state.anchor;
  anchor_from_before_ = state.anchor_from_before;
  lagging_ = state.lagging;
  last_step_ = state.last_step;
  came_with_scan_ = state.came_with_scan;
  velocity_ = calm_velocity_ = Velocity2{};
  velocity_known_ = false;
  if (before_) measure_velocity();
}

void MotionModel::measure_velocity() {
  const auto age_s = [this](const Step& step) { return (before_->utime - step.utime).seconds(); };
  // A clock that went backwards starts anew.
  while (!history_.empty() &&
         (age_s(history_.front()) > options_.max_gap_s || age_s(history_.front()) < 0.0)) {
    history_.pop_front();
  }
  const double calm_span_s = std::max(options_.velocity_span_s, kCalmPeriods * period_s_);
  while (history_.size() > 1 && age_s(history_[1]) >= calm_span_s) history_.pop_front();
  const auto youngest = std::find_if(history_.rbegin(), history_.rend(), [&](const Step& step) {
    return age_s(step) >= options_.velocity_span_s;
  });
  const std::optional<Velocity2> newest =
      history_.empty() ? std::nullopt
                       : velocity_over(youngest == history_.rend() ? history_.front() : *youngest);
  velocity_known_ = newest.has_value();
  velocity_ = newest.value_or(Velocity2{});
  calm_velocity_ =
      history_.empty() ? Velocity2{} : velocity_over(history_.front()).value_or(Velocity2{});
}

std::optional<Velocity2> MotionModel::velocity_over(const MotionState::Step& step) const {
  return believed_velocity(step.then_from_now, (before_->utime - step.utime).seconds(), options_);
}

}  // namespace marco::slam
