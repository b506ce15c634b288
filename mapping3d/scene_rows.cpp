#include "mapping3d/scene_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/covariance.hpp"

namespace marco::mapping3d {
namespace {

// How much later than the newest pose a scan may come and still find its own.
constexpr double kLateS = 10.0;

struct Bearings {
  double first_rad, step_rad;
};

// Nothing where a row of a scene cannot hold the scan.
std::optional<Bearings> even_bearings(const LaserScan& scan) {
  if (scan.bearings_rad.empty()) return Bearings{scan.first_bearing_rad, scan.bearing_step_rad};
  constexpr double kOfAStep = 0.1;  // no beam falls to its neighbour
  if (scan.size() < 2 || scan.bearings_rad.size() != scan.size()) return std::nullopt;
  const double first_rad = scan.bearing_rad(0);
  const double step_rad =
      (scan.bearing_rad(scan.size() - 1) - first_rad) / static_cast<double>(scan.size() - 1);
  for (std::size_t beam = 0; beam < scan.size(); ++beam) {
    const double off_rad =
        scan.bearing_rad(beam) - first_rad - static_cast<double>(beam) * step_rad;
    if (!(std::abs(off_rad) <= kOfAStep * std::abs(step_rad))) return std::nullopt;
  }
  return Bearings{first_rad, step_rad};
}

// When each beam was measured, as a part of the scan. Empty where they were measured one after
// another in equal steps.
std::vector<float> beam_parts(const std::vector<float>& offsets_s, double duration_s) {
  constexpr double kStampS = 2e-6;  // messages round times to microseconds
  const double step_s = duration_s / std::max(1.0, static_cast<double>(offsets_s.size()) - 1.0);
  std::vector<float> parts;
  bool are_even = true;
  for (std::size_t beam = 0; beam < offsets_s.size(); ++beam) {
    const double even_s = static_cast<double>(beam) * step_s;
    are_even &= std::abs(static_cast<double>(offsets_s[beam]) - even_s) <= kStampS;
    parts.push_back(offsets_s[beam] / static_cast<float>(std::max(duration_s, 1e-6)));
  }
  return are_even ? std::vector<float>{} : parts;
}

std::vector<float> ranges_with_returns(const LaserScan& scan, const SensorInfo& info) {
  std::vector<float> ranges_m;
  ranges_m.reserve(scan.size());
  for (const float range_m : scan.ranges_m) {
    const auto range = static_cast<double>(range_m);
    ranges_m.push_back(range >= info.range_min_m && range < info.range_max_m ? range_m : 0.0F);
  }
  return ranges_m;
}

Utime last_beam_of(const SynchronizedScan& scan) {
  return scan.scan.utime + Duration::from_seconds(scan.duration_s);
}

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

bool has_even_bearings(const LaserScan& scan) { return even_bearings(scan).has_value(); }

SceneRows::SceneRows(const PanTiltCorrection& correction, double patience_s, CountDrop drop)
    : correction_(correction), patience_s_(patience_s), drop_(std::move(drop)) {}

void SceneRows::add(SynchronizedScan scan) {
  newest_ = scan.scan.utime;
  waiting_.push_back(std::move(scan));
}

std::optional<PlacedRow> SceneRows::next(const SensorInfo* pantilt_base) {
  while (!waiting_.empty() && (complete_ || is_due(waiting_.front()))) {
    const SynchronizedScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    if (auto row = row_of(scan, pantilt_base)) return row;
  }
  return std::nullopt;
}

void SceneRows::follow(const PathCorrection& correction) {
  poses_.follow(correction,
                waiting_.empty() ? std::nullopt : std::optional(waiting_.front().scan.utime));
}

bool SceneRows::is_due(const SynchronizedScan& scan) const {
  return std::abs((newest_ - scan.scan.utime).seconds()) > patience_s_ ||
         poses_.reach(scan.scan.utime, last_beam_of(scan));
}

bool SceneRows::stands_during(const SynchronizedScan& scan) const {
  return scan.odometry_step && stood_still({}, *scan.odometry_step) &&
         !poses_.moved_until_pose_at(scan.scan.utime, last_beam_of(scan));
}

std::optional<Utime> SceneRows::stop_of(const SynchronizedScan& scan) {
  const auto& odom_from_robot = scan.motion.odom_from_robot;
  const Utime utime = scan.scan.utime;
  if (!odom_from_robot) {
    stop_.reset();
    return std::nullopt;
  }
  const bool stands = stop_ && stood_still(stop_->odom_from_robot, *odom_from_robot) &&
                      !poses_.moved_between(stop_->newest, utime);
  if (!stands) stop_ = {utime, utime, *odom_from_robot};
  stop_->newest = utime;
  return stop_->since;
}

std::optional<PlacedRow> SceneRows::row_of(const SynchronizedScan& synchronized,
                                           const SensorInfo* pantilt_base) {
  const LaserScan& scan = synchronized.scan;
  const SensorInfo& info = synchronized.info;
  const PanTiltAngles &first = synchronized.first_angles, &last = synchronized.last_angles;
  const Pose2* const world_from_robot = poses_.find(scan.utime);
  const bool is_fixed = info.mount == SensorInfo::Mount::robot;
  const auto drop = [this](const char* cause) {
    drop_(cause);
    return std::nullopt;
  };
  if (world_from_robot == nullptr) return drop("scan without SLAM_POSE");
  if (!is_fixed && !synchronized.angles_known) return drop("scan without pan-tilt angles");
  const auto place_at = [&](const PanTiltAngles& angles) {
    if (is_fixed) return info.parent_from_sensor;
    return robot_from_pantilt_sensor(correction_.base(*pantilt_base), correction_.sensor(info),
                                     angles.pan_rad, angles.tilt_rad);
  };
  const Bearings bearings = *even_bearings(scan);
  SceneRow row;
  row.utime = scan.utime;
  row.ranges_m = ranges_with_returns(scan, info);
  row.beam_parts = beam_parts(scan.time_offsets_s, synchronized.duration_s);
  row.first_bearing_rad = bearings.first_rad;
  row.bearing_step_rad = bearings.step_rad;
  row.robot_from_sensor_first = place_at(first);
  row.robot_from_sensor_last = place_at(last);
  row.world_from_robot = *world_from_robot;
  row.stop = stop_of(synchronized);
  if (!stands_during(synchronized)) {
    row.first_robot_from_last_robot =
        marco::between(*world_from_robot, poses_.at(last_beam_of(synchronized)));
  }
  row.duration_s = synchronized.duration_s;
  row.pan_first_rad = first.pan_rad;
  row.pan_last_rad = last.pan_rad;
  row.tilt_first_rad = first.tilt_rad;
  row.tilt_last_rad = last.tilt_rad;
  return PlacedRow{std::move(row),
                   first.pan_rad + 0.5 * normalize_angle(last.pan_rad - first.pan_rad),
                   0.5 * (first.tilt_rad + last.tilt_rad), info.channel};
}

}  // namespace marco::mapping3d
