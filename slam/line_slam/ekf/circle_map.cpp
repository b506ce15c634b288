#include "slam/line_slam/ekf/circle_map.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "slam/line_slam/ekf/joint_compatibility.hpp"

namespace marco::slam {
namespace {

// Of all scans together, in which BIC prefers the circle (ObservedCircle::advantage), and of one on
// average: square legs come out near zero, posts above one.
constexpr double kProved = 15.0, kProvedEach = 1.0;
constexpr int kProvedTimes = 3, kCandidateSteps = 40;
constexpr double kCandidateSigmaM = 0.015;  // of the pose from scan to scan
constexpr double kFloorM = 0.003;           // nothing is quite round

Pose2 pose_of(const EkfState& state) {
  const Eigen::Vector4d robot = state.mean(0);
  return {robot.x(), robot.y(), normalize_angle(robot.z())};
}

Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, const Pose2& pose) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = pose.rotation();
  return rotation * covariance * rotation.transpose();
}

Eigen::Matrix3d with_floor(const Eigen::Matrix3d& covariance) {
  return covariance + kFloorM * kFloorM * Eigen::Matrix3d::Identity();
}

}  // namespace

namespace {

// Corrections are what a filter's step costs, and a post that was seen often gains little from
// each.
bool tells_much(const EkfState& state, const SparseRows& rows) {
  constexpr double kLeastGain = 0.05;  // of the noise's variance: the estimate gains 2.5 %
  const Eigen::Matrix3d known = state.covariance_between(rows, rows);
  const Eigen::Matrix3d noise = rows.noise;
  return (known.diagonal().array() > kLeastGain * noise.diagonal().array()).any();
}

}  // namespace

CircleMap::CircleMap(const WallFilterOptions& options)
    : options_(options), gate_(chi_square_limit(3, options.gate_probability)) {}

std::vector<int> CircleMap::blocks() const {
  std::vector<int> all;
  for (const MapCircle& circle : circles_) all.push_back(circle.block);
  return all;
}

// Centre in the robot's frame, and radius.
SparseRows CircleMap::measurement(const EkfState& state,
                                  const ObservedCircle& observed,
                                  std::size_t index) const {
  const int block = circles_[index].block;
  const Eigen::Vector4d mean = state.mean(block), first = state.first_estimate(block);
  const Eigen::Vector4d robot_first = state.first_estimate(0);
  const Eigen::Matrix2d to_robot = Pose2{0.0, 0.0, -state.mean(0).z()}.rotation();
  const Eigen::Matrix2d to_robot_first = Pose2{0.0, 0.0, -robot_first.z()}.rotation();
  SparseRows rows;
  rows.resize(3);
  rows.num_blocks = 2;
  rows.blocks = {0, block, 0};
  const Eigen::Vector2d lever = to_robot_first * (first.head<2>() - robot_first.head<2>());
  rows.jacobian.block<2, 2>(0, 0) = -to_robot_first;
  rows.jacobian.block<2, 1>(0, 2) = -turned_left(lever);
  rows.jacobian.block<2, 2>(0, 4) = to_robot_first;
  rows.jacobian(2, 6) = 1.0;
  rows.innovation.head<2>() =
      observed.centre_m - to_robot * (mean.head<2>() - state.mean(0).head<2>());
  rows.innovation(2) = observed.radius_m - mean[2];
  rows.noise = with_floor(observed.covariance);
  return rows;
}

std::vector<int> CircleMap::associate(const EkfState& state,
                                      const std::vector<ObservedCircle>& observed) const {
  std::vector<Pairing> pairings;
  std::vector<SparseRows> rows;
  std::vector<std::size_t> circle_of;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    for (std::size_t j = 0; j < circles_.size(); ++j) {
      const MapCircle& circle = circles_[j];
      if (circle.from_inside != observed[i].from_inside) continue;
      SparseRows row = measurement(state, observed[i], j);
      const Eigen::Matrix3d s = state.innovation_covariance(row);
      const Eigen::Vector3d nu = row.innovation;
      const double distance2 = nu.dot(s.ldlt().solve(nu));
      if (!(distance2 <= gate_)) continue;
      // Of a wall several pieces may be seen at once, of a post one.
      const bool post = observed[i].radius_m <= kLargestPostM;
      pairings.push_back({static_cast<int>(i), post ? static_cast<int>(j) : Pairing::kAnyTimes,
                          nu.head<2>(), s.topLeftCorner<2, 2>(), distance2});
      rows.push_back(row);
      circle_of.push_back(j);
    }
  }
  const auto cross = [&](int a, int b) -> Eigen::Matrix2d {
    return state
        .covariance_between(rows[static_cast<std::size_t>(a)], rows[static_cast<std::size_t>(b)])
        .topLeftCorner(2, 2);
  };
  const std::vector<int> chosen = joint_compatibility(
      pairings, cross, static_cast<int>(observed.size()), options_.gate_probability);
  std::vector<int> matches(observed.size(), kNew);
  for (const Pairing& pairing : pairings) {
    matches[static_cast<std::size_t>(pairing.observation)] = kUnclear;
  }
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (chosen[i] >= 0) {
      matches[i] = static_cast<int>(circle_of[static_cast<std::size_t>(chosen[i])]);
    }
  }
  return matches;
}

void CircleMap::correct(EkfState& state,
                        const std::vector<ObservedCircle>& observed,
                        const std::vector<int>& matches) {
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i] < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i]);
    const SparseRows rows = measurement(state, observed[i], index);
    if (tells_much(state, rows)) state.correct(rows);
    ++circles_[index].times_seen;
    circles_[index].advantage += observed[i].advantage;
  }
}

void CircleMap::extend(const EkfState& state,
                       const std::vector<ObservedCircle>& observed,
                       const std::vector<int>& matches) {
  const double heading_rad = state.mean(0).z();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i] < 0) continue;
    MapCircle& circle = circles_[static_cast<std::size_t>(matches[i])];
    circle.arc.grow(heading_rad + observed[i].from_rad, observed[i].span_rad);
  }
}

void CircleMap::add_new(EkfState& state,
                        const std::vector<ObservedCircle>& observed,
                        const std::vector<int>& matches) {
  const Pose2 pose = pose_of(state);
  for (CircleCandidate& candidate : candidates_) ++candidate.times_looked;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i] != kNew) continue;
    Eigen::Vector3d seen;
    seen << pose * observed[i].centre_m, observed[i].radius_m;
    const Eigen::Matrix3d noise = turned(observed[i].covariance, pose) +
                                  kCandidateSigmaM * kCandidateSigmaM * Eigen::Matrix3d::Identity();
    CircleCandidate* best = nullptr;
    double least = gate_;
    for (CircleCandidate& candidate : candidates_) {
      if (candidate.from_inside != observed[i].from_inside) continue;
      const Eigen::Vector3d off = seen - candidate.mean;
      const double distance2 = off.dot((candidate.covariance + noise).ldlt().solve(off));
      if (distance2 > least) continue;
      least = distance2;
      best = &candidate;
    }
    if (best == nullptr) {
      candidates_.push_back({seen, noise, observed[i].from_inside, 1, 0, observed[i].advantage});
      continue;
    }
    const Eigen::Matrix3d gain = best->covariance * (best->covariance + noise).inverse();
    best->mean += gain * (seen - best->mean);
    best->covariance = best->covariance - gain * best->covariance;
    ++best->times_seen;
    best->times_looked = 0;
    best->advantage += observed[i].advantage;
    const auto times = static_cast<double>(best->times_seen);
    if (best->times_seen < kProvedTimes ||
        best->advantage < std::max(kProved, kProvedEach * times)) {
      continue;
    }
    add(state, observed[i], *best);
    candidates_.erase(candidates_.begin() + (best - candidates_.data()));
  }
  std::erase_if(candidates_, [](const CircleCandidate& candidate) {
    return candidate.times_looked > kCandidateSteps;
  });
}

// State augmentation, as of a wall (WallMap::add).
void CircleMap::add(EkfState& state,
                    const ObservedCircle& observed,
                    const CircleCandidate& proved) {
  const Pose2 pose = pose_of(state);
  Eigen::Vector4d mean;
  mean << pose * observed.centre_m, observed.radius_m, 0.0;
  const Eigen::Vector2d from_m = state.first_estimate(0).head<2>();
  Eigen::Matrix<double, 4, 3> by_robot = Eigen::Matrix<double, 4, 3>::Zero();
  by_robot.topLeftCorner<2, 2>().setIdentity();
  by_robot.block<2, 1>(0, 2) = turned_left(mean.head<2>() - from_m);
  Eigen::Matrix4d noise = Eigen::Matrix4d::Zero();
  noise.topLeftCorner<3, 3>() = turned(with_floor(observed.covariance), pose);
  MapCircle circle;
  circle.id = next_id_++;
  circle.block = state.append(mean, mean, by_robot, noise);
  circle.times_seen = proved.times_seen;
  circle.from_inside = observed.from_inside;
  circle.advantage = proved.advantage;
  circle.arc = SeenArc(options_.evidence, pose.theta_rad + observed.from_rad, observed.span_rad,
                       observed.radius_m);
  circles_.push_back(std::move(circle));
}

void CircleMap::remove(EkfState& state, std::size_t index) {
  state.remove(circles_[index].block);
  if (index + 1 != circles_.size()) circles_[index] = std::move(circles_.back());
  circles_.pop_back();
}

void CircleMap::restore(EkfState& state, const Stored& stored) {
  for (const MapCircle& circle : stored.circles) {
    const SeenArc& arc = circle.arc;
    require(std::isfinite(arc.from_rad) && arc.span_rad >= 0.0 &&
                arc.span_rad <= 2.0 * std::numbers::pi && arc.scale_m > 0.0 &&
                std::isfinite(arc.scale_m),
            "wall_filter: a stored arc has no extent");
  }
  circles_ = stored.circles;
  candidates_ = stored.candidates;
  next_id_ = stored.next_id;
  for (MapCircle& circle : circles_) {
    circle.block = state.append(Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(),
                                Eigen::Matrix<double, 4, 3>::Zero(), Eigen::Matrix4d::Zero());
  }
}

}  // namespace marco::slam
