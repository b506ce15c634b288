#include "slam/front_end/dead_reckoning.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// Beyond it the last velocity says nothing; and over less a stamp's error makes nonsense of it.
constexpr double kMaxGapS = 1.0, kVelocitySpanS = 0.15;

// Over a single scan period, a velocity that deskews scans which take as long feeds back.
constexpr double kSmoothedPeriods = 1.8;

// The velocity may change at once and then stay: a step of acceleration * dt over dt.
Eigen::Matrix3d covariance_after(double dt_s, const MotionOptions& options) {
  const double sigma_m = kMoveSigmaM + options.acceleration_m_per_s2 * dt_s * dt_s;
  const double sigma_deg = kMoveSigmaDeg + options.turn_acceleration_deg_per_s2 * dt_s * dt_s;
  return diagonal_covariance(sigma_m, deg_to_rad(sigma_deg));
}

}  // namespace

MotionGuess DeadReckoning::by_time(Utime now) const {
  const double dt_s = (now - *state_.newest).seconds();
  const double dt = std::clamp(dt_s, 0.0, kMaxGapS);
  MotionGuess guess;
  guess.drift = covariance_after(dt, options_);
  if (velocity_ && dt == dt_s) {
    guess.source = MotionGuess::Source::velocity;
    guess.before_from_now = velocity_->after(dt);
  }
  return guess;
}

MotionGuess DeadReckoning::by_scans() const {
  const double dt_s = std::min(state_.scan_period_s, kMaxGapS);
  MotionGuess guess{state_.last_step, covariance_after(dt_s, options_)};
  guess.source = MotionGuess::Source::velocity;
  return guess;
}

bool DeadReckoning::scans_are_the_clock(Utime now) const {
  // No logger stalls for longer: scans are missing.
  const double dt_s = (now - *state_.newest).seconds();
  return state_.clock_contest > 0.0 && state_.scan_period_s > 0.0 && dt_s <= kMaxGapS;
}

MotionGuess DeadReckoning::guess(Utime now, const Pose2& now_from_middle) const {
  if (!state_.newest) return {};
  MotionGuess guess = scans_are_the_clock(now) ? by_scans() : by_time(now);
  guess.before_from_now =
      state_.newest_from_middle * guess.before_from_now * now_from_middle.inverse();
  return guess;
}

std::optional<Velocity2> DeadReckoning::velocity_to(Utime now,
                                                    const Pose2& before_from_middle) const {
  if (!state_.newest) return std::nullopt;
  const double dt_s =
      scans_are_the_clock(now) ? state_.scan_period_s : (now - *state_.newest).seconds();
  if (dt_s > kMaxGapS) return std::nullopt;
  const Pose2 step = state_.newest_from_middle.inverse() * before_from_middle;
  return believed_velocity(step, dt_s, options_);
}

void DeadReckoning::update(Utime now,
                           double scan_period_s,
                           const Pose2& before_from_now,
                           bool matched,
                           const Pose2& now_from_middle) {
  if (state_.newest) {
    const Pose2 step = state_.newest_from_middle.inverse() * before_from_now * now_from_middle;
    if (matched) judge_clocks(now, step);
    state_.history.push_back({*state_.newest, Pose2{}});
    for (DeadReckoningState::Step& then : state_.history) {
      then.then_from_now = then.then_from_now * step;
    }
    state_.last_step = step;
  }
  state_.newest = now;
  state_.newest_from_middle = now_from_middle;
  state_.scan_period_s = scan_period_s;
  measure_velocity();
}

void DeadReckoning::judge_clocks(Utime now, const Pose2& step) {
  constexpr double kFresh = 0.05;       // weight of the newest: the last 20 scans, 2 to 4 s
  constexpr double kMostPerScan = 2.0;  // one wrong match must not decide
  constexpr double kAlikeM = 0.05, kAlikeDeg = 2.0;  // smaller errors count alike
  const auto error2 = [&](const MotionGuess& guess) {
    const Eigen::Vector3d off = difference(step, guess.before_from_now);
    const double turns = off.z() / deg_to_rad(kAlikeDeg);
    return 1.0 + off.head<2>().squaredNorm() / (kAlikeM * kAlikeM) + turns * turns;
  };
  const MotionGuess timed = by_time(now);
  if (timed.source == MotionGuess::Source::nothing) return;  // after a gap, neither can be judged
  const double log_ratio = std::log(error2(timed) / error2(by_scans()));
  state_.clock_contest +=
      kFresh * (std::clamp(log_ratio, -kMostPerScan, kMostPerScan) - state_.clock_contest);
}

void DeadReckoning::restore(const DeadReckoningState& state) {
  state_ = state;
  measure_velocity();
}

void DeadReckoning::measure_velocity() {
  std::deque<DeadReckoningState::Step>& history = state_.history;
  velocity_.reset();
  smoothed_velocity_ = {};
  if (!state_.newest) return;
  const auto age_s = [this](const DeadReckoningState::Step& step) {
    return (*state_.newest - step.utime).seconds();
  };
  // A clock that was set back makes steps of the future.
  while (!history.empty() && (age_s(history.front()) > kMaxGapS || age_s(history.front()) < 0.0)) {
    history.pop_front();
  }
  const double span_s = std::max(kVelocitySpanS, kSmoothedPeriods * state_.scan_period_s);
  while (history.size() > 1 && age_s(history[1]) >= span_s) history.pop_front();
  if (history.empty()) return;
  const auto velocity_since = [&](const DeadReckoningState::Step& step) {
    return believed_velocity(step.then_from_now, age_s(step), options_);
  };
  const auto youngest = std::find_if(history.rbegin(), history.rend(), [&](const auto& step) {
    return age_s(step) >= kVelocitySpanS;
  });
  velocity_ = velocity_since(youngest == history.rend() ? history.front() : *youngest);
  smoothed_velocity_ = velocity_since(history.front()).value_or(Velocity2{});
}

}  // namespace marco::slam
