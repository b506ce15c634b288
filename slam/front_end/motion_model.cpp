#include "slam/front_end/motion_model.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"
#include "common/input/odometry_track.hpp"

namespace marco::slam {
namespace {

// Odometry that claims more between two scans is not believed.
constexpr double kMaxStepM = 8.0;

// Of a gyroscope's heading: its stamps.
constexpr double kGyroJitterDeg = 0.1;

double square(double value) { return value * value; }

void take_translation(const MotionGuess& from, MotionGuess& guess) {
  guess.before_from_now.x_m = from.before_from_now.x_m;
  guess.before_from_now.y_m = from.before_from_now.y_m;
  guess.drift.topLeftCorner<2, 2>() = from.drift.topLeftCorner<2, 2>();
  guess.jitter.topLeftCorner<2, 2>() = from.jitter.topLeftCorner<2, 2>();
}

void take_rotation(const MotionGuess& from, MotionGuess& guess) {
  guess.before_from_now.theta_rad = from.before_from_now.theta_rad;
  guess.drift(2, 2) = from.drift(2, 2);
  guess.jitter(2, 2) = from.jitter(2, 2);
  guess.turn_by_gyro = from.turn_by_gyro;
}

}  // namespace

MotionModel::MotionModel(const MotionOptions& options) : options_(options), reckoning_(options) {
  validate(options, "motion");
}

bool MotionModel::has_stood_still(const MotionInput& now) const {
  const auto& before = state_.before->odom_from_robot;
  return before && now.odom_from_robot && stood_still(*before, *now.odom_from_robot);
}

std::optional<MotionGuess> MotionModel::from_odometry(const MotionInput& now) const {
  const MotionInput& before = *state_.before;
  if (!now.odom_from_robot || !before.odom_from_robot) return std::nullopt;
  const Pose2 step = between(*before.odom_from_robot, *now.odom_from_robot);
  const double dt_s = (now.utime - before.utime).seconds();
  const double distance_m = step.translation_m().norm();
  if (distance_m > std::max(kMaxStepM, options_.max_speed_m_per_s * dt_s)) return std::nullopt;
  MotionGuess guess{step, state_.odometry_noise.drift(step), state_.odometry_noise.jitter(),
                    MotionGuess::Source::odometry};
  // A stamp off the beat may belong to another moment than the step, unless the step is a usual
  // one.
  const double off_m = std::min(now.off_beat * state_.move_m, std::abs(distance_m - state_.move_m));
  const double off_rad = std::min(now.off_beat * state_.turn_rad,
                                  std::abs(std::abs(step.theta_rad) - state_.turn_rad));
  guess.jitter += diagonal_covariance(off_m, off_rad);
  // Of odometry that exceeds the limits the last velocity knows as much.
  const double passed_s = std::max(dt_s, now.scan_period_s);
  if (passed_s > 1e-3 && !believed_velocity(step, passed_s, options_)) {
    const Velocity2 velocity = reckoning_.velocity().value_or(Velocity2{});
    guess.drift.diagonal() += between(velocity.after(passed_s), step).vector().cwiseAbs2();
  }
  return guess;
}

std::optional<MotionGuess> MotionModel::from_gyro(const MotionInput& now) const {
  const MotionInput& before = *state_.before;
  if (!now.gyro_heading_rad || !before.gyro_heading_rad) return std::nullopt;
  const double dt_s = std::abs((now.utime - before.utime).seconds());
  MotionGuess guess;
  guess.before_from_now.theta_rad =
      normalize_angle(*now.gyro_heading_rad - *before.gyro_heading_rad);
  guess.drift(2, 2) = square(deg_to_rad(options_.gyro_sigma_deg_per_s * dt_s));
  guess.jitter(2, 2) = std::max(square(deg_to_rad(kGyroJitterDeg)), state_.gyro_error.rad2);
  guess.turn_by_gyro = true;
  return guess;
}

Pose2 MotionModel::filtered(const MotionInput& now,
                            const Pose2& before_from_now,
                            const Eigen::Matrix3d& covariance) const {
  const MotionGuess predicted = guess_by_velocity(now);
  if (predicted.source != MotionGuess::Source::velocity) return before_from_now;
  const Eigen::Matrix2d expected =
      std::max(square(kMoveSigmaM), 0.5 * state_.reckoning_error.m2) * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d off_m =
      before_from_now.translation_m() - predicted.before_from_now.translation_m();
  const Eigen::Vector2d shift_m =
      predicted.before_from_now.translation_m() +
      expected * (expected + covariance.topLeftCorner<2, 2>()).inverse() * off_m;
  return {shift_m.x(), shift_m.y(), before_from_now.theta_rad};
}

MotionGuess MotionModel::guess_by_velocity(const MotionInput& now) const {
  return reckoning_.guess(now.utime, now.first_from_middle);
}

MotionGuess MotionModel::guess(const MotionInput& now, bool will_match) const {
  if (!state_.before) return {};
  MotionGuess guess = guess_by_velocity(now);
  double error_rad2 = state_.reckoning_error.rad2;
  // Odometry that has never moved may be broken, or the robot has stood still: only a motion
  // decides. After a gap, where nothing else is known, it is believed.
  const bool may_be_broken = !state_.odometry_has_moved && will_match &&
                             guess.source == MotionGuess::Source::velocity && has_stood_still(now);
  const auto odometry = may_be_broken ? std::nullopt : from_odometry(now);
  if (odometry) {
    const PredictionError &error = state_.odometry_error, &other = state_.reckoning_error;
    const bool moves = state_.explained_by_odometry.explains_translation();
    const bool turns = state_.explained_by_odometry.explains_rotation();
    // Where one half is doubted, the other has to be better than dead reckoning.
    const bool sure = moves && turns;
    if (sure) guess.source = MotionGuess::Source::odometry;
    if (moves && (sure || error.m2 <= other.m2)) take_translation(*odometry, guess);
    if (turns && (sure || error.rad2 <= other.rad2)) {
      take_rotation(*odometry, guess);
      error_rad2 = error.rad2;
    }
  }
  const auto gyro = from_gyro(now);
  if (gyro && state_.explained_by_gyro.explains_rotation() &&
      state_.gyro_error.rad2 <= error_rad2 && gyro->covariance()(2, 2) < guess.covariance()(2, 2)) {
    take_rotation(*gyro, guess);
  }
  return guess;
}

bool MotionModel::trusts_odometry() const {
  return state_.explained_by_odometry.explains_translation() &&
         state_.explained_by_odometry.explains_rotation();
}

bool MotionModel::stands_still(const MotionInput& now, const Eigen::Matrix3d& information) const {
  // What matches of a standing robot differ by.
  constexpr double kCalmM = 5e-3, kCalmDeg = 0.3;
  if (!state_.before || !state_.before->odom_from_robot || !now.odom_from_robot) return false;
  if (!trusts_odometry()) return false;
  // Odometry that has never moved has to be confirmed, in every direction.
  constexpr double kConfirmedM = 0.03;
  if (!state_.odometry_has_moved && position_sigma_m(covariance_of(information)) > kConfirmedM) {
    return false;
  }
  // Two matches of one place differ by 1.8 standard deviations in the mean.
  constexpr double kSigmas = 3.0;
  // In the direction that it knows well: along a bare corridor it knows nothing.
  const double sigma_m = std::sqrt(2.0 / (information(0, 0) + information(1, 1)));
  const double sigma_rad = 1.0 / std::sqrt(information(2, 2));
  return stood_still(*state_.before->odom_from_robot, *now.odom_from_robot) &&
         state_.move_m <= std::max(kCalmM, kSigmas * sigma_m) &&
         state_.turn_rad <= std::max(deg_to_rad(kCalmDeg), kSigmas * sigma_rad);
}

bool MotionModel::exceeds_motion_limits(const Pose2& moved, Utime now) const {
  constexpr double kM = 0.3, kDeg = 30.0;  // of any two scans: stamps may be of the same moment
  if (!state_.before) return false;
  const double since_s = std::abs((now - state_.before->utime).seconds());
  return moved.translation_m().norm() > kM + since_s * options_.max_speed_m_per_s ||
         std::abs(moved.theta_rad) > deg_to_rad(kDeg + since_s * options_.max_turn_rate_deg_per_s);
}

ScanVelocity MotionModel::velocity_during(const std::optional<Pose2>& odometry_step,
                                          double duration_s) const {
  // Over less, odometry's own steps make nonsense of it.
  constexpr double kLongScanS = 0.05;
  const ScanVelocity predicted{reckoning_.smoothed_velocity()};
  if (duration_s < kLongScanS || !odometry_step || !trusts_odometry()) return predicted;
  const auto measured = believed_velocity(*odometry_step, duration_s, options_);
  return measured ? ScanVelocity{*measured, true} : predicted;
}

void MotionModel::update(const MotionInput& now,
                         const Pose2& before_from_now,
                         bool matched,
                         const Eigen::Matrix3d& covariance) {
  constexpr double kFresh = 0.3;  // weight of the newest: the last three scans
  Pose2 step = before_from_now;
  if (state_.before) {
    const double sigma_m = position_sigma_m(covariance);
    if (matched) step = filtered(now, before_from_now, covariance);
    if (matched) judge_predictions(now, before_from_now, sigma_m);
    judge_sensors(now, before_from_now, matched, sigma_m);
    if (state_.before->odom_from_robot && now.odom_from_robot && !has_stood_still(now)) {
      state_.odometry_has_moved = true;
    }
    state_.move_m += kFresh * (before_from_now.translation_m().norm() - state_.move_m);
    state_.turn_rad += kFresh * (std::abs(before_from_now.theta_rad) - state_.turn_rad);
  }
  state_.before = now;
  reckoning_.update(now.utime, now.scan_period_s, step, matched, now.first_from_middle);
}

void MotionModel::judge_predictions(const MotionInput& now,
                                    const Pose2& before_from_now,
                                    double sigma_m) {
  const auto judge = [&](PredictionError& error, const MotionGuess& guess) {
    // Along a bare corridor the match is the guess, or slides.
    const bool surer = sigma_m < std::max(kMoveSigmaM, position_sigma_m(guess.covariance()));
    error.update(difference(before_from_now, guess.before_from_now), surer);
  };
  judge(state_.reckoning_error, guess_by_velocity(now));
  if (const auto odometry = from_odometry(now)) judge(state_.odometry_error, *odometry);
  if (const auto gyro = from_gyro(now)) judge(state_.gyro_error, *gyro);
}

void MotionModel::judge_sensors(const MotionInput& now,
                                const Pose2& before_from_now,
                                bool matched,
                                double sigma_m) {
  constexpr double kStepS = 1.0;  // in a shorter one noise of matches hides what sensors miss
  state_.start_from_now = state_.start_from_now * before_from_now;
  const auto begin_step = [&] {
    state_.step_start = matched ? std::optional(now) : std::nullopt;
    state_.start_from_now = {};
    state_.step_start_sigma_m = sigma_m;
  };
  if (!matched || !state_.step_start) return begin_step();
  const MotionInput& start = *state_.step_start;
  if (std::abs((now.utime - start.utime).seconds()) < kStepS) return;
  const Pose2& found = state_.start_from_now;
  if (start.odom_from_robot && now.odom_from_robot) {
    const Pose2 measured = between(*start.odom_from_robot, *now.odom_from_robot);
    const double step_sigma_m = std::hypot(sigma_m, state_.step_start_sigma_m);
    state_.explained_by_odometry.update(found, measured, step_sigma_m);
  }
  if (start.gyro_heading_rad && now.gyro_heading_rad) {
    Pose2 measured = found;
    measured.theta_rad = normalize_angle(*now.gyro_heading_rad - *start.gyro_heading_rad);
    state_.explained_by_gyro.update(found, measured, 0.0);
  }
  begin_step();
}

MotionState MotionModel::state() const {
  MotionState state = state_;
  state.reckoning = reckoning_.state();
  return state;
}

void MotionModel::restore(const MotionState& state) {
  state_ = state;
  reckoning_.restore(state.reckoning);
}

}  // namespace marco::slam
