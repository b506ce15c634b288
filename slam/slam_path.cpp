// What Slam keeps of its path: the scans between keyframes, and the trail of keyframes that were.
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/slam.hpp"

namespace marco::slam {
namespace {

// Poses of a short path's trail for each keyframe of the map.
constexpr std::size_t kTrailPerKey = 4;

}  // namespace

void Slam::keep_short_path(double every_m, std::size_t first) {
  require(every_m >= 0.0, "a path of less than no distance between poses");
  path_every_m_ = every_m;
  short_path_from_ = first;
}

bool Slam::is_worth_keeping(const ScanPose& scan) const {
  if (!path_every_m_ || scans_.size() <= short_path_from_) return true;
  const ScanPose& last = scans_.back();
  if (last.key != scan.key) return true;  // each keyframe's own is
  const Pose2 moved = between(last.key_from_robot, scan.key_from_robot);
  return moved.translation_m().norm() >= *path_every_m_ ||
         std::abs(moved.theta_rad) >= *path_every_m_;
}

void Slam::forget_scans_of(int key) {
  if (!path_every_m_) return;
  const auto first =
      scans_.begin() + static_cast<std::ptrdiff_t>(std::min(short_path_from_, scans_.size()));
  const auto hangs_on = [key](const ScanPose& scan) { return scan.key == key; };
  scans_.erase(std::remove_if(first, scans_.end(), hangs_on), scans_.end());
}

void Slam::thin_trail() {
  if (!path_every_m_ || trail_.size() <= kTrailPerKey * keys_.size()) return;
  // Every second one of the older half: what is long past is known in ever larger steps.
  const auto middle = trail_.begin() + static_cast<std::ptrdiff_t>(trail_.size() / 2);
  bool drop = false;
  const auto kept_until = std::remove_if(trail_.begin(), middle, [&](const ScanPose& pose) {
    if (keys_[static_cast<std::size_t>(pose.key)].utime == pose.utime) return false;
    return drop = !drop;
  });
  trail_.erase(kept_until, middle);
}

void Slam::rehang_scans(int key, const MergedKeyframe& merged) {
  // No scan before the keyframe's own hangs on it, or on a newer one.
  const Utime utime = keys_[static_cast<std::size_t>(key)].utime;
  for (std::vector<ScanPose>* scans : {&scans_, &trail_}) {
    for (auto scan = scans->rbegin(); scan != scans->rend(); ++scan) {
      const bool is_first = scan->key == key && scan->utime == utime;
      if (scan->key > key) {
        --scan->key;
      } else if (scan->key == key) {
        *scan = {scan->utime, merged.into, merged.into_from_key * scan->key_from_robot};
      }
      if (is_first) break;
    }
  }
}

}  // namespace marco::slam
