#include "common/input/odometry_track.hpp"

#include <algorithm>
#include <cmath>

namespace marco {
namespace {

// One scan alone may be a stall; and the balance of votes ends at three times as many.
constexpr int kSureVotes = 3;

// A turn counts as the way of a point so far off.
constexpr double kLeverArmM = 0.5;

double distance(const Pose2& a, const Pose2& b) {
  const Pose2 off = between(a, b);
  return std::hypot(off.x_m, off.y_m) + kLeverArmM * std::abs(off.theta_rad);
}

}  // namespace

bool stood_still(const Pose2& before, const Pose2& now) {
  constexpr double kNoStepM = 5e-4, kNoTurnDeg = 0.03;  // less than two counts of usual encoders
  const Pose2 step = between(before, now);
  return step.translation_m().norm() <= kNoStepM &&
         std::abs(step.theta_rad) <= deg_to_rad(kNoTurnDeg);
}

bool OdometryTrack::restarts_at(const OdometrySample& sample) const {
  // No robot of ours drives so fast, nor turns more than once in a second.
  constexpr double kFarM = 1.0, kFarMPerS = 5.0, kLongestS = 10.0;
  constexpr double kFarRad = 1.0, kFarRadPerS = 7.0;
  // A base that was started again counts from zero; driving, nobody passes zero so exactly.
  constexpr double kZeroM = 1e-3, kZeroRad = 2e-3, kElsewhereM = 0.05;
  if (samples_.empty()) return false;
  const double dt_s = std::clamp((sample.utime - samples_.newest()).seconds(), 0.0, kLongestS);
  const Pose2& now = sample.odom_from_robot;
  const Pose2 moved = between(samples_.newest_pose(), now);
  const double moved_m = moved.translation_m().norm();
  const bool at_zero = now.translation_m().norm() <= kZeroM && std::abs(now.theta_rad) <= kZeroRad;
  return moved_m > kFarM + kFarMPerS * dt_s ||
         std::abs(moved.theta_rad) > kFarRad + kFarRadPerS * dt_s ||
         (at_zero && moved_m > kElsewhereM);
}

void OdometryTrack::add(const OdometrySample& sample) {
  samples_.add(sample.utime, sample.odom_from_robot);
}

void OdometryTrack::clear() {
  samples_.clear();
  own_before_.reset();
}

std::optional<Pose2> OdometryTrack::own_of(Utime stamp) const {
  if (samples_.empty() || samples_.newest() != stamp) return std::nullopt;
  return samples_.newest_pose();
}

void OdometryTrack::note(const AtScan& scan) {
  constexpr double kClearM =
      0.02;  // both moments' motions differ by more than wheels and stamps are off
  // Of a step longer than that the stamps may be right, and scans are missing.
  constexpr double kStalledPeriods = 0.15, kStalledS = 0.005;
  // What was looked up by a stamp is explained by it, to this part of what the beat leaves.
  constexpr double kExplained = 0.1;
  if (scan.own && own_before_ && scan.period_s > 0.0) {
    const Pose2 step = between(*own_before_, *scan.own);
    const double step_s = (scan.stamp - stamp_before_).seconds();
    const double periods = step_s / scan.period_s;
    if (scan.repaired == scan.stamp) {
      const double part = 1.0 / std::max(1.0, std::round(periods));
      beat_step_ = {part * step.x_m, part * step.y_m, part * step.theta_rad};
    } else if (periods < kStalledPeriods && step_s < kStalledS) {
      const double part = std::clamp(periods, -1.0, 1.0);
      const Pose2& beat = beat_step_;
      const double off_beat = distance(step, beat);
      const double off_stamp =
          distance(step, {part * beat.x_m, part * beat.y_m, part * beat.theta_rad});
      int vote = 0;
      if (off_beat - off_stamp >= kClearM && off_stamp < kExplained * off_beat) vote = 1;
      if (off_stamp - off_beat >= kClearM) vote = -1;
      looked_up_ = std::clamp(looked_up_ + vote, -3 * kSureVotes, 3 * kSureVotes);
    }
  }
  own_before_ = scan.own;
  stamp_before_ = scan.stamp;
}

bool OdometryTrack::is_looked_up() const { return looked_up_ >= kSureVotes; }

Utime OdometryTrack::moment_of(const AtScan& scan) const {
  return scan.own && !is_looked_up() ? scan.stamp : scan.repaired;
}

bool OdometryTrack::covers(const AtScan& scan, double duration_s, double patience_s) const {
  if (samples_.empty() || (scan.own && !is_looked_up())) return true;
  const Utime needed = moment_of(scan) + Duration::from_seconds(duration_s);
  return samples_.newest() >= needed || (needed - samples_.newest()).seconds() > patience_s;
}

std::optional<Pose2> OdometryTrack::at(const AtScan& scan, double reach_s) const {
  if (scan.own && !is_looked_up()) return scan.own;
  return samples_.at(moment_of(scan), Duration::from_seconds(reach_s));
}

std::optional<Pose2> OdometryTrack::motion_during(const AtScan& scan, double duration_s) const {
  return samples_.motion_during(moment_of(scan), Duration::from_seconds(duration_s));
}

}  // namespace marco
