#include "slam/map/keyframe.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// What a file may claim: beyond these cells do not fit an int, and sums lose millimetres.
constexpr double kFarthestM = 1e6;
constexpr double kFarthestPathM = 1e9;
constexpr int32_t kMostMerged = 100'000'000;  // 30000 km of path

}  // namespace

bool is_near(const Pose2& pose) {
  return std::abs(pose.x_m) <= kFarthestM && std::abs(pose.y_m) <= kFarthestM;
}

bool is_index(int index, std::size_t count) {
  return index >= 0 && static_cast<std::size_t>(index) < count;
}

bool KeyframeSet::is_due(const Pose2& world_from_robot,
                         double sensor_heading_rad,
                         const KeyframeOptions& options) const {
  const double turn_rad = deg_to_rad(options.keyframe_turn_deg);
  // Several lasers, or one that pans, look several ways from one place.
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
    const Pose2 moved = between(key->world_from_robot, world_from_robot);
    if (moved.translation_m().norm() >= options.keyframe_distance_m ||
        std::abs(moved.theta_rad) >= turn_rad) {
      return true;
    }
    const double panned_rad = normalize_angle(sensor_heading_rad - key->sensor_heading_rad);
    if (std::abs(panned_rad) < turn_rad) return false;
  }
  return true;
}

void check(const KeyframeSet& keyframes) {
  for (const Keyframe& key : keyframes.keys) {
    const Points2& points = key.points_in_robot.points;
    require(points.cols() == key.points_in_robot.normals.cols(),
            "a keyframe needs one normal per point");
    require(is_near(key.world_from_robot) &&
                (points.size() == 0 || points.cwiseAbs().maxCoeff() <= kFarthestM) &&
                key.sensor_in_robot.cwiseAbs().maxCoeff() <= kFarthestM &&
                std::abs(key.path_m) <= kFarthestPathM,
            "a keyframe is farther away than 1000 km");
  }
  require(keyframes.merged >= 0 && keyframes.merged <= kMostMerged,
          "the number of merged keyframes is impossible");
}

Trajectory trajectory_of(const std::vector<Keyframe>& keys) {
  Trajectory trajectory;
  trajectory.reserve(keys.size());
  for (const Keyframe& key : keys) trajectory.push_back({key.utime, key.world_from_robot});
  return trajectory;
}

OrientedPoints join_points(const std::vector<Keyframe>& keys,
                           int first,
                           int last,
                           const Pose2& frame_from_world) {
  Eigen::Index count = 0;
  for (int key = first; key <= last; ++key) {
    count += keys[static_cast<std::size_t>(key)].points_in_robot.points.cols();
  }
  OrientedPoints joined{Points2(2, count), Points2(2, count)};
  Eigen::Index at = 0;
  for (int key = first; key <= last; ++key) {
    const Keyframe& scan = keys[static_cast<std::size_t>(key)];
    const Pose2 frame_from_robot = frame_from_world * scan.world_from_robot;
    const Eigen::Index part = scan.points_in_robot.points.cols();
    joined.points.middleCols(at, part) = frame_from_robot * scan.points_in_robot.points;
    joined.normals.middleCols(at, part) =
        frame_from_robot.rotation() * scan.points_in_robot.normals;
    joined.range_sigma_m = std::max(joined.range_sigma_m, scan.points_in_robot.range_sigma_m);
    at += part;
  }
  return joined;
}

}  // namespace marco::slam
