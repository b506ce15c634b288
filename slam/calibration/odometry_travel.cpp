#include "slam/calibration/odometry_travel.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/median.hpp"

namespace marco::slam {
namespace {

// Across a longer gap nobody knows on which way the robot went.
constexpr double kLongestGapS = 1.0;

// No robot goes so far between two samples.
bool is_jump(const Pose2& moved, double dt_s) {
  return moved.translation_m().norm() > 1.0 + 5.0 * dt_s ||
         std::abs(moved.theta_rad) > 1.0 + 7.0 * dt_s;
}

ArcMotion sum(const ArcMotion& a, const ArcMotion& b, double part = 1.0) {
  return {a.ahead_m + part * b.ahead_m, a.left_m + part * b.left_m, a.turn_rad + part * b.turn_rad};
}

}  // namespace

OdometryTravel::OdometryTravel(const Trajectory& odometry) {
  Trajectory ascending;
  for (const StampedPose2& sample : odometry) {
    while (!ascending.empty() && ascending.back().utime >= sample.utime) ascending.pop_back();
    ascending.push_back(sample);
  }
  for (std::size_t i = 0; i < ascending.size(); ++i) {
    seconds_.push_back(ascending[i].utime.seconds());
    if (i == 0) {
      sums_.emplace_back();
      continue;
    }
    const Pose2 moved = between(ascending[i - 1].world_from_robot, ascending[i].world_from_robot);
    const double dt_s = seconds_[i] - seconds_[i - 1];
    const bool gap = dt_s > kLongestGapS || is_jump(moved, dt_s);
    if (gap) gaps_s_.push_back(seconds_[i - 1]);
    sums_.push_back(gap ? sums_.back() : sum(sums_.back(), ArcMotion::of(moved)));
  }
}

double OdometryTravel::interval_s() const {
  std::vector<double> intervals_s(seconds_.size());
  std::adjacent_difference(seconds_.begin(), seconds_.end(), intervals_s.begin());
  return median(std::move(intervals_s));
}

double OdometryTravel::to_sample_s(double moment_s) const {
  const auto after = std::lower_bound(seconds_.begin(), seconds_.end(), moment_s);
  double nearest_s = after == seconds_.end() ? moment_s - seconds_.back() : *after - moment_s;
  if (after != seconds_.begin()) nearest_s = std::min(nearest_s, moment_s - *(after - 1));
  return nearest_s;
}

bool OdometryTravel::knows(double begin_s, double end_s) const {
  if (empty() || begin_s < seconds_.front() || end_s > seconds_.back()) return false;
  const auto next = std::upper_bound(gaps_s_.begin(), gaps_s_.end(), begin_s - 1e-9);
  const bool starts_in_gap =
      next != gaps_s_.begin() &&
      *std::upper_bound(seconds_.begin(), seconds_.end(), *(next - 1)) > begin_s;
  return !starts_in_gap && (next == gaps_s_.end() || *next >= end_s);
}

ArcMotion OdometryTravel::at(double moment_s) const {
  const auto after = std::upper_bound(seconds_.begin(), seconds_.end(), moment_s);
  if (after == seconds_.begin()) return sums_.front();
  if (after == seconds_.end()) return sums_.back();
  const auto i = static_cast<std::size_t>(after - seconds_.begin());
  const double part = (moment_s - seconds_[i - 1]) / (seconds_[i] - seconds_[i - 1]);
  return sum(sum(sums_[i - 1], sums_[i - 1], -part), sums_[i], part);
}

ArcMotion OdometryTravel::between_moments(double begin_s, double end_s) const {
  return sum(at(end_s), at(begin_s), -1.0);
}

}  // namespace marco::slam
