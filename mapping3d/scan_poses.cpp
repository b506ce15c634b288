#include "mapping3d/scan_poses.hpp"

#include <algorithm>

#include "common/covariance.hpp"

namespace marco::mapping3d {
namespace {

// How much later than the newest pose a scan may come and still find its own.
constexpr double kLateS = 10.0;

}  // namespace

void ScanPoses::add(const PoseEstimate& pose) {
  if (newest_) {
    const Eigen::Vector3d moved = difference(pose.world_from_robot, newest_->world_from_robot);
    const Eigen::Matrix3d information = information_of(newest_->covariance + pose.covariance);
    if (squared_mahalanobis_distance(moved, information) > kChi2Dof3Quantile999) {
      moved_at_.insert(pose.utime);
    }
  }
  poses_[pose.utime] = pose.world_from_robot;
  newest_ = pose;
}

const Pose2* ScanPoses::find(Utime utime) const {
  const auto pose = poses_.find(utime);
  return pose != poses_.end() ? &pose->second : nullptr;
}

bool ScanPoses::reach(Utime utime, Utime until) const {
  return poses_.contains(utime) && poses_.rbegin()->first >= until;
}

Pose2 ScanPoses::at(Utime utime) const {
  auto after = poses_.lower_bound(utime);
  if (after == poses_.end() && poses_.size() > 1) after = std::prev(after);
  if (after == poses_.end()) return poses_.rbegin()->second;
  if (after->first == utime || after == poses_.begin()) return after->second;
  const auto before = std::prev(after);
  const double part = (utime - before->first).seconds() / (after->first - before->first).seconds();
  return interpolate(before->second, after->second, std::min(part, 2.0));
}

bool ScanPoses::moved_between(Utime from, Utime until) const {
  const auto after = moved_at_.upper_bound(from);
  return after != moved_at_.end() && *after <= until;
}

bool ScanPoses::moved_until_pose_at(Utime from, Utime until) const {
  const auto next = poses_.lower_bound(until);
  return next != poses_.end() && moved_between(from, next->first);
}

void ScanPoses::follow(const PathCorrection& correction, std::optional<Utime> oldest_needed) {
  if (poses_.empty()) return;
  for (auto& [utime, world_from_robot] : poses_) {
    world_from_robot = correction.corrected(utime, world_from_robot);
  }
  Utime needed = poses_.rbegin()->first - Duration::from_seconds(kLateS);
  if (oldest_needed) needed = std::min(needed, *oldest_needed);
  // at() looks at the pose before, too.
  const auto first_needed = poses_.lower_bound(needed);
  const auto kept = first_needed == poses_.begin() ? first_needed : std::prev(first_needed);
  if (kept != poses_.end()) {
    moved_at_.erase(moved_at_.begin(), moved_at_.lower_bound(kept->first));
  }
  for (auto pose = poses_.begin(); pose != kept;) {
    pose = correction.has_key(pose->first) ? std::next(pose) : poses_.erase(pose);
  }
}

}  // namespace marco::mapping3d
