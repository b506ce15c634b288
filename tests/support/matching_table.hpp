#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/matching_world.hpp"

namespace marco::testing {

/// One match to make: two scans, the true move and where the matcher starts.
struct MatchTrial {
  Points2 target, source;
  Pose2 truth, start;
  Eigen::Matrix3d bound;  ///< Cramer-Rao, of (x, y, theta) in the source's axes, the walls known
  Eigen::Matrix3d honest_bound;  ///< the same where only the two scans know of the walls
};

/// The Cramer-Rao bound of the move between two scans for somebody who knows that walls are
/// straight but not where they are: each wall's distance and direction are estimated, too. What one
/// scan alone sees of the world tells nothing.
/// @returns covariance of (x, y, theta) in the source's axes.
inline Eigen::Matrix3d bound_of_unknown_walls(const MatchingScan& target,
                                              const MatchingScan& source,
                                              const Pose2& target_from_source,
                                              int walls,
                                              double noise_m) {
  const Eigen::Index size = 3 + 2 * walls;
  // What is not seen at all has a prior of 100 m and as many radians.
  Eigen::MatrixXd information = 1e-4 * Eigen::MatrixXd::Identity(size, size);
  const auto add = [&](const WallBeam& beam, const Pose2& target_from_scan, bool moves) {
    const Eigen::Vector2d n = target_from_scan.rotation() * beam.normal;
    const Eigen::Vector2d p = target_from_scan * beam.point;
    Eigen::VectorXd j = Eigen::VectorXd::Zero(size);
    if (moves) {
      j.head<3>() << -beam.normal,
          beam.normal.x() * beam.point.y() - beam.normal.y() * beam.point.x();
    }
    j.segment<2>(3 + 2 * beam.wall) << 1.0, n.x() * p.y() - n.y() * p.x();
    const double incidence = beam.normal.dot(beam.point.normalized()) * noise_m;
    information += j * j.transpose() / std::max(1e-12, incidence * incidence);
  };
  for (const WallBeam& beam : target.inliers) add(beam, {}, false);
  for (const WallBeam& beam : source.inliers) add(beam, target_from_source, true);
  const Eigen::MatrixXd covariance = information.inverse();
  return covariance.topLeftCorner<3, 3>();
}

/// Our protocol for table 5.1: in the room, from a random place, a step of 50 cm or a turn of
/// 25 deg (the lab run's); odometry off by up to 20 % of either and as much again in the other.
inline MatchTrial match_trial(const MatchingWorld& world,
                              double outlier_part,
                              std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  MatchingLaser laser;
  laser.outlier_part = outlier_part;
  const Pose2 here{4.0 + 0.9 * uniform(random), 3.4 + 0.6 * uniform(random),
                   std::numbers::pi * uniform(random)};
  const double sign = uniform(random) > 0.0 ? 1.0 : -1.0;
  const bool turns = uniform(random) > 0.0;
  const Pose2 move = turns ? Pose2{0.0, 0.0, sign * deg_to_rad(25.0)} : Pose2{sign * 0.5, 0.0, 0.0};
  const Pose2 off{0.1 * uniform(random), 0.1 * uniform(random), deg_to_rad(5.0) * uniform(random)};
  const MatchingScan target = take_scan(world, here, laser, random);
  const MatchingScan source = take_scan(world, here * move, laser, random);
  // The target's own uncertainty, carried to the source's frame, adds to the source's.
  const double c = std::cos(move.theta_rad), s = std::sin(move.theta_rad);
  Eigen::Matrix3d carry;
  carry << c, s, -c * move.y_m + s * move.x_m, -s, c, s * move.y_m + c * move.x_m, 0, 0, 1;
  const Eigen::Matrix3d bound =
      source.fisher.inverse() + carry * target.fisher.inverse() * carry.transpose();
  return {target.points_in_robot,
          source.points_in_robot,
          move,
          move * off,
          bound,
          bound_of_unknown_walls(target, source, move, world.wall_count(), laser.noise_m)};
}

struct ErrorColumn {
  double mean = 0.0, deviation = 0.0, max = 0.0;
};
/// The mean error of a Gaussian at a Cramer-Rao bound.
struct ErrorBound {
  double angle_deg = 0.0, translation_cm = 0.0;

  // E|e| = sigma sqrt(2/pi); of two axes of equal variance sigma sqrt(pi/2).
  void add(const Eigen::Matrix3d& covariance, int count) {
    angle_deg += rad_to_deg(std::sqrt(covariance(2, 2) * 2.0 / std::numbers::pi)) / count;
    const double axis_m2 = 0.5 * (covariance(0, 0) + covariance(1, 1));
    translation_cm += 100.0 * std::sqrt(axis_m2 * std::numbers::pi / 2.0) / count;
  }
};
struct MatchTable {
  ErrorColumn angle_deg, translation_cm;
  ErrorBound bound;         ///< walls known
  ErrorBound honest_bound;  ///< walls known from the two scans alone
};

inline ErrorColumn error_column(const std::vector<double>& errors) {
  ErrorColumn column;
  for (const double e : errors) column.mean += e / static_cast<double>(errors.size());
  for (const double e : errors) {
    column.deviation += (e - column.mean) * (e - column.mean) / static_cast<double>(errors.size());
    column.max = std::max(column.max, e);
  }
  column.deviation = std::sqrt(column.deviation);
  return column;
}

/// @param match the pose found for a trial. @param count of trials; the seed makes them the same
/// for every matcher.
inline MatchTable match_table(double outlier_part,
                              int count,
                              unsigned seed,
                              const std::function<Pose2(const MatchTrial&)>& match) {
  std::mt19937 random(seed);
  const MatchingWorld world = matching_room();
  std::vector<double> angles_deg, translations_cm;
  MatchTable table;
  for (int i = 0; i < count; ++i) {
    const MatchTrial trial = match_trial(world, outlier_part, random);
    const Pose2 off = between(trial.truth, match(trial));
    angles_deg.push_back(rad_to_deg(std::abs(off.theta_rad)));
    translations_cm.push_back(100.0 * off.translation_m().norm());
    table.bound.add(trial.bound, count);
    table.honest_bound.add(trial.honest_bound, count);
  }
  table.angle_deg = error_column(angles_deg);
  table.translation_cm = error_column(translations_cm);
  return table;
}

}  // namespace marco::testing
