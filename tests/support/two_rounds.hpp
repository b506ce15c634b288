#pragma once

#include <numbers>
#include <vector>

#include "common/covariance.hpp"
#include "slam/doctor/doctor.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::testing {

/// What a map holds after two rounds of a robot in small_room(), a keyframe each 0.3 m, a second
/// each; chain edges as matches make them, no loops. `off` is added, in the world, to the keyframes
/// of the second round: the scans are those of the true place.
struct TwoRounds {
  static constexpr int kOfRound = 40;

  explicit TwoRounds(const Pose2& off = {}, const FlatWorld& second = small_room()) {
    const FlatWorld first = small_room();
    for (int i = 0; i < 2 * kOfRound; ++i) {
      const bool is_second = i >= kOfRound;
      const Pose2 truth = place(i);
      slam::Keyframe key;
      key.utime = Utime::from_us(1'000'000 * static_cast<int64_t>(i));
      key.points_in_robot = slam::orient((is_second ? second : first).hits(truth, 0.01, &random),
                                         Eigen::Vector2d::Zero(), {});
      key.world_from_robot = is_second ? off * truth : truth;
      key.path_m = 0.3 * i;
      map.keys.push_back(key);
      if (i > 0) add_step(i);
    }
    map.paths = {{path(), odometry()}};
  }

  static Pose2 place(int i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / kOfRound;
    // Round the middle, the laser looking outwards and ahead.
    return {1.2 * std::cos(angle_rad), 0.6 + 1.0 * std::sin(angle_rad), normalize_angle(angle_rad)};
  }
  /// An edge from the keyframe before, as the map has it.
  void add_step(int to) {
    const Eigen::Matrix3d information = information_of(diagonal_covariance(0.01, deg_to_rad(0.15)));
    const auto pose = [this](int key) {
      return map.keys[static_cast<std::size_t>(key)].world_from_robot;
    };
    map.edges.push_back({to - 1, to, between(pose(to - 1), pose(to)), information, false});
  }
  void add_loop(int from, int to, const Pose2& from_from_to, bool in_force) {
    slam::Loop loop;
    loop.from = from;
    loop.to = to;
    loop.from_from_to = from_from_to;
    loop.information = information_of(diagonal_covariance(0.02, deg_to_rad(0.3)));
    loop.overlap = 0.9;
    loop.is_inlier = in_force;
    map.edges.push_back(loop.edge());
    map.loops.push_back(loop);
  }
  Trajectory path() const {
    Trajectory result;
    for (const slam::Keyframe& key : map.keys) result.push_back({key.utime, key.world_from_robot});
    return result;
  }
  static Trajectory odometry() {
    Trajectory result;
    for (int i = 0; i < 2 * kOfRound; ++i) {
      result.push_back({Utime::from_us(1'000'000 * static_cast<int64_t>(i)), place(i)});
    }
    return result;
  }

  std::mt19937 random{8};
  slam::MapEvidence map;
};

}  // namespace marco::testing
