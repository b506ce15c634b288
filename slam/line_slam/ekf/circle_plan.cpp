#include <algorithm>
#include <cmath>
#include <numbers>

#include "slam/line_slam/ekf/circle_map.hpp"

namespace marco::slam {
namespace {

// Of a radius, what all scans share: spots at an edge answer by what of them is nearer.
constexpr double kSharedSigmaM = 0.0025;

}  // namespace

bool CircleMap::is_in_reach(const Eigen::Vector3d& circle, const Pose2& world_from_robot) const {
  const double off_m = (circle.head<2>() - world_from_robot.translation_m()).norm() - circle.z();
  return std::abs(off_m) <= options_.judged_within_m;
}

void CircleMap::judge(EkfState& state, const ScanInRobot& scan, double pose_margin_m) {
  const Eigen::Vector4d robot = state.mean(0);
  const Pose2 pose{robot.x(), robot.y(), normalize_angle(robot.z())};
  for (std::size_t i = circles_.size(); i-- > 0;) {
    MapCircle& circle = circles_[i];
    const Eigen::Vector3d mean = state.mean(circle.block).head<3>();
    if (!is_in_reach(mean, pose)) continue;
    circle.arc.vote_by_rays(scan, pose, mean, circle.from_inside, pose_margin_m);
    circle.arc.evidence.count_votes(options_.evidence);
    const bool gone = circle.arc.evidence.existence() < options_.evidence.forget_probability;
    if (gone || circle.advantage < 0.0) remove(state, i);
  }
}

void CircleMap::forget_evidence() {
  for (MapCircle& circle : circles_) circle.arc.evidence.forget(options_.evidence);
}

void CircleMap::vote(const EkfState& state,
                     const ScanInRobot& scan,
                     const Pose2& world_from_robot) {
  for (MapCircle& circle : circles_) {
    const Eigen::Vector3d mean = state.mean(circle.block).head<3>();
    if (!is_in_reach(mean, world_from_robot)) continue;
    circle.arc.vote_by_rays(scan, world_from_robot, mean, circle.from_inside, 0.0);
    circle.arc.evidence.count_votes(options_.evidence);
  }
}

bool CircleMap::holds(const EkfState& state, const Eigen::Vector4d& wall) const {
  constexpr double kNearM = 0.06;  // a chord of 1 m lies so far inside a wall of 2 m radius
  const auto lies_on = [&](const MapCircle& circle, const Eigen::Vector2d& point_m) {
    const Eigen::Vector4d mean = state.mean(circle.block);
    const Eigen::Vector2d off_m = point_m - mean.head<2>();
    if (mean[2] <= kLargestPostM || std::abs(off_m.norm() - mean[2]) > kNearM) return false;
    const double turn = turn_between(circle.arc.from_rad, std::atan2(off_m.y(), off_m.x()));
    const double beyond_m = mean[2] * std::min(std::max(0.0, turn - circle.arc.span_rad),
                                               2.0 * std::numbers::pi - turn);
    return beyond_m < 3.0 * kNearM;
  };
  const Eigen::Vector2d start_m = wall.head<2>(), end_m = wall.tail<2>();
  return std::any_of(circles_.begin(), circles_.end(), [&](const MapCircle& circle) {
    return lies_on(circle, start_m) && lies_on(circle, end_m) &&
           lies_on(circle, 0.5 * (start_m + end_m));
  });
}

RoundWalls CircleMap::plan(const EkfState& state, int64_t min_times_seen) const {
  RoundWalls plan;
  for (const MapCircle& circle : circles_) {
    if (circle.times_seen < min_times_seen) continue;
    const Eigen::Vector4d mean = state.mean(circle.block);
    RoundWall piece;
    piece.id = circle.id;
    piece.centre_m = mean.head<2>();
    piece.radius_m = mean[2];
    piece.covariance = state.covariance(circle.block, circle.block).topLeftCorner<3, 3>();
    piece.covariance(2, 2) += kSharedSigmaM * kSharedSigmaM;
    piece.from_inside = circle.from_inside;
    piece.existence = circle.arc.evidence.existence();
    piece.times_seen = circle.times_seen;
    for (const SeenArc::Run& run : circle.arc.standing(piece.radius_m, options_.evidence)) {
      piece.from_rad = run.from_rad;
      piece.span_rad = run.span_rad;
      plan.push_back(piece);
    }
  }
  return plan;
}

}  // namespace marco::slam
