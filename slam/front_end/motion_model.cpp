#include "slam/front_end/motion_model.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kSigmaFloorM = 0.01, kSigmaFloorDeg = 0.5, kSigmaDegPerM = 2.0;

// Odometry that claims more between two scans is not believed.
constexpr double kMaxStepM = 8.0;

// Beyond it the last velocity says nothing; and over less a stamp's error makes nonsense of it.
constexpr double kMaxGapS = 1.0, kVelocitySpanS = 0.15;

// Over a single scan period, a velocity that deskews scans which take as long feeds back.
constexpr double kSmoothedPeriods = 1.8;

double square(double value) { return value * value; }

Eigen::Matrix3d diagonal(double sigma_m, double sigma_deg) {
  return Eigen::Vector3d(square(sigma_m), square(sigma_m), square(deg_to_rad(sigma_deg)))
      .asDiagonal();
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

MotionGuess MotionModel::from_odometry(const Pose2& step, double passed_s, double off_beat) const {
  const double distance_m = step.translation_m().norm();
  const double turn_deg = std::abs(rad_to_deg(step.theta_rad));
  MotionGuess guess;
  guess.source = MotionGuess::Source::odometry;
  guess.before_from_now = step;
  guess.covariance =
      diagonal(std::hypot(kSigmaFloorM, options_.sigma_per_m * distance_m),
               kSigmaFloorDeg + kSigmaDegPerM * distance_m + options_.sigma_deg_per_deg * turn_deg);
  // A stamp off the beat may belong to another moment than the step, unless the step is a usual
  // one.
  const double off_m = std::min(off_beat * state_.move_m, std::abs(distance_m - state_.move_m));
  const double off_rad =
      std::min(off_beat * state_.turn_rad, std::abs(std::abs(step.theta_rad) - state_.turn_rad));
  guess.covariance.diagonal() += Eigen::Vector3d(square(off_m), square(off_m), square(off_rad));
  // Of odometry that exceeds the limits the last velocity knows as much.
  if (passed_s > 1e-3 && !believed_velocity(step, passed_s, options_)) {
    const Pose2 off = between(velocity_.value_or(Velocity2{}).after(passed_s), step);
    guess.covariance.diagonal() += off.vector().cwiseAbs2();
  }
  return guess;
}

MotionGuess MotionModel::from_velocity(double dt_s) const {
  const double dt = std::clamp(dt_s, 0.0, kMaxGapS);
  MotionGuess guess;
  if (velocity_ && dt == dt_s) {
    guess.source = MotionGuess::Source::velocity;
    guess.before_from_now = velocity_->after(dt);
  }
  // The velocity may change at once and then stay: a step of acceleration * dt over dt.
  guess.covariance = diagonal(kSigmaFloorM + options_.acceleration_m_per_s2 * dt * dt,
                              kSigmaFloorDeg + options_.turn_acceleration_deg_per_s2 * dt * dt);
  return guess;
}

void MotionModel::fuse_gyro(const MotionInput& now, MotionGuess& guess) const {
  const MotionInput& before = *state_.before;
  if (!now.gyro_heading_rad || !before.gyro_heading_rad) return;
  const double dt_s = std::abs((now.utime - before.utime).seconds());
  const double sigma_rad = deg_to_rad(0.1 + options_.gyro_sigma_deg_per_s * dt_s);
  if (square(sigma_rad) >= guess.covariance(2, 2)) return;
  guess.before_from_now.theta_rad =
      normalize_angle(*now.gyro_heading_rad - *before.gyro_heading_rad);
  guess.covariance(2, 2) = square(sigma_rad);
}

MotionGuess MotionModel::guess(const MotionInput& now) const {
  if (!state_.before) return {};
  const MotionInput& before = *state_.before;
  const double dt_s = (now.utime - before.utime).seconds();
  MotionGuess guess = from_velocity(dt_s);
  if (now.odom_from_robot && before.odom_from_robot) {
    const Pose2 step = between(*before.odom_from_robot, *now.odom_from_robot);
    if (step.translation_m().norm() <= std::max(kMaxStepM, options_.max_speed_m_per_s * dt_s)) {
      guess = from_odometry(step, std::max(dt_s, now.scan_period_s), now.off_beat);
    }
  }
  fuse_gyro(now, guess);
  return guess;
}

bool MotionModel::stands_still(const MotionInput& now) const {
  // Less than wheels can tell; and what matches of a standing robot differ by.
  constexpr double kNoStepM = 5e-4, kNoTurnDeg = 0.03, kCalmM = 5e-3, kCalmDeg = 0.3;
  if (!state_.before || !state_.before->odom_from_robot || !now.odom_from_robot) return false;
  const Pose2 step = between(*state_.before->odom_from_robot, *now.odom_from_robot);
  return step.translation_m().norm() <= kNoStepM &&
         std::abs(step.theta_rad) <= deg_to_rad(kNoTurnDeg) && state_.move_m <= kCalmM &&
         state_.turn_rad <= deg_to_rad(kCalmDeg);
}

bool MotionModel::exceeds_motion_limits(const Pose2& moved, Utime now) const {
  constexpr double kM = 0.3, kDeg = 30.0;
  if (!state_.before) return false;
  const double since_s = std::abs((now - state_.before->utime).seconds());
  return moved.translation_m().norm() > kM + since_s * options_.max_speed_m_per_s ||
         std::abs(moved.theta_rad) > deg_to_rad(kDeg + since_s * options_.max_turn_rate_deg_per_s);
}

void MotionModel::update(const MotionInput& now, const Pose2& before_from_now) {
  constexpr double kFresh = 0.3;
  if (state_.before) {
    state_.move_m += kFresh * (before_from_now.translation_m().norm() - state_.move_m);
    state_.turn_rad += kFresh * (std::abs(before_from_now.theta_rad) - state_.turn_rad);
    state_.history.push_back({state_.before->utime, Pose2{}});
    for (MotionState::Step& step : state_.history) {
      step.then_from_now = step.then_from_now * before_from_now;
    }
  }
  state_.before = now;
  state_.scan_period_s = now.scan_period_s;
  measure_velocity();
}

void MotionModel::restore(const MotionState& state) {
  state_ = state;
  velocity_.reset();
  smoothed_velocity_ = {};
  if (state_.before) measure_velocity();
}

void MotionModel::measure_velocity() {
  std::deque<MotionState::Step>& history = state_.history;
  const auto age_s = [this](const MotionState::Step& step) {
    return (state_.before->utime - step.utime).seconds();
  };
  // A clock that was set back makes steps of the future.
  while (!history.empty() && (age_s(history.front()) > kMaxGapS || age_s(history.front()) < 0.0)) {
    history.pop_front();
  }
  const double span_s = std::max(kVelocitySpanS, kSmoothedPeriods * state_.scan_period_s);
  while (history.size() > 1 && age_s(history[1]) >= span_s) history.pop_front();
  velocity_.reset();
  smoothed_velocity_ = {};
  if (history.empty()) return;
  const auto youngest = std::find_if(history.rbegin(), history.rend(), [&](const auto& step) {
    return age_s(step) >= kVelocitySpanS;
  });
  velocity_ = velocity_since(youngest == history.rend() ? history.front() : *youngest);
  smoothed_velocity_ = velocity_since(history.front()).value_or(Velocity2{});
}

std::optional<Velocity2> MotionModel::velocity_since(const MotionState::Step& step) const {
  return believed_velocity(step.then_from_now, (state_.before->utime - step.utime).seconds(),
                           options_);
}

}  // namespace marco::slam
