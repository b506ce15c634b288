#include "slam/map/scan_path.hpp"

#include <algorithm>
#include <cmath>

#include "common/input/odometry_track.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Keyframe poses of a short path for each keyframe of the map.
constexpr std::size_t kPosesPerKeyframe = 4;

// Dead reckoning errs with the way; a radian of turning counts as this many metres.
constexpr double kMPerRad = 0.5;
constexpr double kStoodM = 1e-4;  // a way of rounding errors

// Matches of a robot that stands lie within some millimetres; those of a laser that nods in a room
// of glass and chairs, of which it sees a part at a time, within 2 cm.
constexpr double kStopM = 0.05, kStopDeg = 2.0;

Pose2 world_from_key(const ScanPose& scan, const std::vector<Keyframe>& keys) {
  return scan.key < 0 ? Pose2{} : keys[static_cast<std::size_t>(scan.key)].world_from_robot;
}

// Of one scan, in the world.
struct Correction {
  Pose2 from;  // where its prediction began
  Pose2 predicted;
  Pose2 found;
};

// Scans [first, last) were predicted, and the one after them was found elsewhere. Each takes its
// share of that turn, in proportion to the way, which bends the path; then its share of the shift
// that is left.
template <class WorldFrom>
void spread(std::vector<ScanPose>& scans,
            std::size_t first,
            std::size_t last,
            const WorldFrom& world_from,
            const Correction& correction) {
  std::vector<Pose2> poses{correction.from};
  for (std::size_t i = first; i < last; ++i) {
    poses.push_back(world_from(scans[i]) * scans[i].key_from_robot);
  }
  poses.push_back(correction.predicted);
  std::vector<double> path_m{0.0};  // path length until each of them, turns included
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2 step = between(poses[i - 1], poses[i]);
    path_m.push_back(path_m.back() + step.translation_m().norm() +
                     kMPerRad * std::abs(step.theta_rad));
  }
  if (path_m.back() < kStoodM) return;
  const double off_rad =
      normalize_angle(correction.found.theta_rad - correction.predicted.theta_rad);
  const auto turn_after_rad = [&](double length_m) { return length_m / path_m.back() * off_rad; };
  std::vector<Pose2> bent{poses.front()};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector2d step_m = poses[i].translation_m() - poses[i - 1].translation_m();
    const Eigen::Vector2d at_m =
        bent.back().translation_m() +
        Eigen::Rotation2Dd(turn_after_rad(0.5 * (path_m[i - 1] + path_m[i]))) * step_m;
    bent.push_back({at_m.x(), at_m.y(), poses[i].theta_rad + turn_after_rad(path_m[i])});
  }
  const Eigen::Vector2d left_m = correction.found.translation_m() - bent.back().translation_m();
  for (std::size_t i = 1; i + 1 < poses.size(); ++i) {
    const double part = path_m[i] / path_m.back();
    ScanPose& scan = scans[first + i - 1];
    scan.key_from_robot =
        between(world_from(scan), {bent[i].x_m + part * left_m.x(), bent[i].y_m + part * left_m.y(),
                                   normalize_angle(bent[i].theta_rad)});
  }
}

}  // namespace

void check(const ScanPathState& path, const KeyframeSet& keyframes) {
  const std::size_t count = keyframes.keys.size();
  require(path.keyframe_poses.size() >= count &&
              path.keyframe_poses.size() - count <= static_cast<std::size_t>(keyframes.merged),
          "there are more keyframe poses than keyframes");
  for (const std::vector<ScanPose>* scans : {&path.scans, &path.keyframe_poses}) {
    for (const ScanPose& scan : *scans) {
      require(scan.key == -1 || is_index(scan.key, count),
              "a scan's pose is relative to no keyframe");
      require(is_near(scan.key_from_robot), "a scan is farther away than 1000 km");
    }
  }
  require(std::all_of(path.keyframe_poses.begin(), path.keyframe_poses.end(),
                      [](const ScanPose& pose) { return pose.key >= 0; }),
          "a keyframe's pose is relative to no keyframe");
}

Trajectory trajectory_of(const std::vector<ScanPose>& scans, const std::vector<Keyframe>& keys) {
  Trajectory trajectory;
  trajectory.reserve(scans.size());
  for (const ScanPose& scan : scans) {
    trajectory.push_back({scan.utime, world_from_key(scan, keys) * scan.key_from_robot});
  }
  for (std::size_t i = scans.size(); i-- > 1;) {
    if (scans[i].stands) trajectory[i - 1].world_from_robot = trajectory[i].world_from_robot;
  }
  return trajectory;
}

void ScanPath::restore(const ScanPathState& state) {
  state_ = state;
  stop_begins_ = state_.scans.empty() ? 0 : state_.scans.size() - 1;
  while (stop_begins_ > 0 && state_.scans[stop_begins_].stands) --stop_begins_;
}

bool ScanPath::is_at_stop(const Pose2& world_from_robot, const std::vector<Keyframe>& keys) const {
  if (stop_begins_ >= state_.scans.size()) return false;
  const ScanPose& first = state_.scans[stop_begins_];
  const Pose2 moved = between(world_from_key(first, keys) * first.key_from_robot, world_from_robot);
  return moved.translation_m().norm() <= kStopM &&
         std::abs(moved.theta_rad) <= deg_to_rad(kStopDeg);
}

void ScanPath::keep_short(double every_m, std::size_t first) {
  require(every_m >= 0.0, "a path with a negative distance between poses");
  every_m_ = every_m;
  short_from_ = first;
}

void ScanPath::add_scan(const StampedPose2& scan,
                        const std::optional<Pose2>& odom_from_robot,
                        bool predicted,
                        const std::vector<Keyframe>& keys) {
  const int key = static_cast<int>(keys.size()) - 1;
  ScanPose pose{scan.utime, key, scan.world_from_robot};
  if (!keys.empty()) {
    pose.key_from_robot = between(keys.back().world_from_robot, scan.world_from_robot);
  }
  std::optional<Pose2>& stop = state_.odom_from_stop;
  // Of a short path the scan before may be missing.
  pose.stands = !every_m_ && stop && odom_from_robot && stood_still(*stop, *odom_from_robot) &&
                is_at_stop(scan.world_from_robot, keys);
  if (!pose.stands) {
    stop = odom_from_robot;
    stop_begins_ = state_.scans.size();
  }
  pose.predicted = predicted;
  if (is_worth_keeping(pose)) state_.scans.push_back(pose);
}

void ScanPath::spread_correction(const Pose2& from,
                                 const Pose2& predicted,
                                 const Pose2& world_from_robot,
                                 const std::vector<Keyframe>& keys) {
  std::vector<ScanPose>& scans = state_.scans;
  std::size_t first = scans.size();
  while (first > 0 && scans[first - 1].predicted) --first;
  if (first == 0) return;  // nothing was matched before them
  const auto world_from = [&](const ScanPose& scan) { return world_from_key(scan, keys); };
  spread(scans, first, scans.size(), world_from, {from, predicted, world_from_robot});
}

void ScanPath::spread_moves(const std::vector<Keyframe>& keys,
                            const std::vector<Pose2>& world_from_keys) {
  std::vector<ScanPose>& scans = state_.scans;
  const auto world_from = [&](const ScanPose& scan) {
    return scan.key < 0 ? Pose2{} : world_from_keys[static_cast<std::size_t>(scan.key)];
  };
  for (std::size_t next = 1; next < scans.size(); ++next) {
    const ScanPose &before = scans[next - 1], &after = scans[next];
    if (!before.predicted || before.key < 0 || after.key == before.key) continue;
    const Keyframe& key = keys[static_cast<std::size_t>(before.key)];
    const auto is_between = [&](const ScanPose& scan) {
      return scan.predicted && scan.key == before.key && scan.utime != key.utime;
    };
    std::size_t first = next;
    while (first > 1 && is_between(scans[first - 1])) --first;
    if (first == next) continue;
    const Pose2 was_after = world_from_key(after, keys) * after.key_from_robot;
    spread(scans, first, next, world_from,
           {world_from(before) * scans[first - 1].key_from_robot,
            world_from(before) * between(key.world_from_robot, was_after),
            world_from(after) * after.key_from_robot});
  }
}

bool ScanPath::is_worth_keeping(const ScanPose& scan) const {
  if (!every_m_ || state_.scans.size() <= short_from_) return true;
  const ScanPose& last = state_.scans.back();
  if (last.key != scan.key) return true;  // each keyframe's own is
  const Pose2 moved = between(last.key_from_robot, scan.key_from_robot);
  return moved.translation_m().norm() >= *every_m_ || std::abs(moved.theta_rad) >= *every_m_;
}

void ScanPath::append(const ScanPathState& session,
                      int first_key,
                      const Pose2& world_from_session) {
  for (ScanPose scan : session.scans) {
    if (scan.key < 0) {
      scan.key_from_robot = world_from_session * scan.key_from_robot;
    } else {
      scan.key += first_key;
    }
    state_.scans.push_back(scan);
  }
  for (ScanPose scan : session.keyframe_poses) {
    scan.key += first_key;
    state_.keyframe_poses.push_back(scan);
  }
}

void ScanPath::remove_scans_of(int key) {
  if (!every_m_) return;
  std::vector<ScanPose>& scans = state_.scans;
  const auto first =
      scans.begin() + static_cast<std::ptrdiff_t>(std::min(short_from_, scans.size()));
  const auto is_of_key = [key](const ScanPose& scan) { return scan.key == key; };
  scans.erase(std::remove_if(first, scans.end(), is_of_key), scans.end());
}

void ScanPath::reattach_to_keyframe(int key,
                                    const MergedKeyframe& merged,
                                    const std::vector<Keyframe>& keys) {
  remove_scans_of(key);
  // No scan before the keyframe's own is relative to it, or to a newer one.
  const Utime utime = keys[static_cast<std::size_t>(key)].utime;
  for (std::vector<ScanPose>* scans : {&state_.scans, &state_.keyframe_poses}) {
    for (auto scan = scans->rbegin(); scan != scans->rend(); ++scan) {
      const bool is_first = scan->key == key && scan->utime == utime;
      if (scan->key > key) {
        --scan->key;
      } else if (scan->key == key) {
        scan->key = merged.into;
        scan->key_from_robot = merged.into_from_key * scan->key_from_robot;
      }
      if (is_first) break;
    }
  }
}

void ScanPath::shorten(const std::vector<Keyframe>& keys) {
  std::vector<ScanPose>& poses = state_.keyframe_poses;
  if (!every_m_ || poses.size() <= kPosesPerKeyframe * keys.size()) return;
  // Every second one of the older half: the steps of what is long past grow ever larger.
  const auto middle = poses.begin() + static_cast<std::ptrdiff_t>(poses.size() / 2);
  bool drop = false;
  const auto kept_until = std::remove_if(poses.begin(), middle, [&](const ScanPose& pose) {
    if (keys[static_cast<std::size_t>(pose.key)].utime == pose.utime) return false;
    return drop = !drop;
  });
  poses.erase(kept_until, middle);
}

}  // namespace marco::slam
