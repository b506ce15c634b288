#include "common/trajectory_fit.hpp"

#include <algorithm>
#include <cmath>

#include "common/rigid_fit.hpp"

namespace marco {
namespace {

std::optional<Eigen::Vector2d> position_at(const Trajectory& truth, Utime utime, Duration max_gap) {
  const auto after =
      std::lower_bound(truth.begin(), truth.end(), utime,
                       [](const StampedPose2& pose, Utime t) { return pose.utime < t; });
  if (after == truth.end()) return std::nullopt;
  if (after->utime == utime) return after->world_from_robot.translation_m();
  if (after == truth.begin()) return std::nullopt;
  const auto before = after - 1;
  const Duration gap = after->utime - before->utime;
  if (gap > max_gap) return std::nullopt;
  const double part = (utime - before->utime).seconds() / gap.seconds();
  return interpolate(before->world_from_robot, after->world_from_robot, part).translation_m();
}

Trajectory moved(const Trajectory& trajectory, const Pose2& to_from) {
  Trajectory result = trajectory;
  for (StampedPose2& pose : result) pose.world_from_robot = to_from * pose.world_from_robot;
  return result;
}

// True poses farther apart than this are not interpolated.
constexpr Duration kMaxGap = Duration::from_seconds(1.0);

Trajectory by_time(Trajectory truth) {
  std::stable_sort(truth.begin(), truth.end(),
                   [](const StampedPose2& a, const StampedPose2& b) { return a.utime < b.utime; });
  return truth;
}

TrajectoryFit fit_to_sorted(const Trajectory& estimate,
                            const Trajectory& truth,
                            Duration max_gap,
                            Duration truth_late) {
  const auto size = static_cast<Eigen::Index>(estimate.size());
  Eigen::Matrix2Xd from(2, size), to(2, size);
  Eigen::Index count = 0;
  for (const StampedPose2& pose : estimate) {
    const auto position = position_at(truth, pose.utime + truth_late, max_gap);
    if (!position) continue;
    from.col(count) = pose.world_from_robot.translation_m();
    to.col(count++) = *position;
  }
  TrajectoryFit fit;
  fit.truth_late = truth_late;
  fit.count = static_cast<std::size_t>(count);
  if (fit.count < 2) return fit;
  from.conservativeResize(2, count);
  to.conservativeResize(2, count);
  fit.truth_from_estimate = rigid_fit(from, to);
  const Eigen::VectorXd errors_m = distances_after_fit(from, to);
  fit.rms_m = std::sqrt(errors_m.squaredNorm() / static_cast<double>(count));
  fit.max_m = errors_m.maxCoeff();
  return fit;
}

}  // namespace

TrajectoryFit fit_to_truth(const Trajectory& estimate, const Trajectory& truth, Duration max_gap) {
  return fit_to_sorted(estimate, by_time(truth), max_gap, {});
}

void RecordedTruth::add(const TruePose& pose) {
  poses.push_back({pose.utime, pose.world_from_robot});
  is_by_arrival = is_by_arrival || pose.is_by_arrival;
}

TrajectoryFit fit_to_truth(const Trajectory& estimate, const RecordedTruth& truth) {
  constexpr int64_t kMostUs = 500'000, kFinestUs = 1000;  // of the delay that is searched
  const Trajectory sorted = by_time(truth.poses);
  TrajectoryFit best = fit_to_sorted(estimate, sorted, kMaxGap, {});
  if (!truth.is_by_arrival) return best;
  // The error is smooth in the delay: steps of half the reach, then halved around the best.
  for (int64_t step_us = kMostUs / 2; step_us >= kFinestUs; step_us /= 2) {
    for (bool better = true; better;) {
      better = false;
      for (const int64_t late_us : {best.truth_late.us - step_us, best.truth_late.us + step_us}) {
        if (std::abs(late_us) > kMostUs) continue;
        const TrajectoryFit fit =
            fit_to_sorted(estimate, sorted, kMaxGap, Duration::from_us(late_us));
        if (fit.count < 2 || fit.rms_m >= best.rms_m) continue;
        best = fit;
        better = true;
      }
    }
  }
  return best;
}

Trajectory truth_on_estimate(const Trajectory& estimate, const RecordedTruth& truth) {
  const TrajectoryFit fit = fit_to_truth(estimate, truth);
  return fit.count < 2 ? Trajectory{} : moved(truth.poses, fit.truth_from_estimate.inverse());
}

Trajectory odometry_on_estimate(const Trajectory& estimate, const Trajectory& odometry) {
  if (estimate.empty() || odometry.empty()) return {};
  return moved(odometry,
               estimate.front().world_from_robot * odometry.front().world_from_robot.inverse());
}

}  // namespace marco
