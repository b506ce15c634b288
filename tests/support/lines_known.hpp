#pragma once

#include <random>
#include <vector>

#include "slam/line_slam/ekf/wall_filter.hpp"
#include "tests/support/lines_drive.hpp"
#include "tests/support/lines_world.hpp"

namespace marco::testing {

/// Runs of the filter with known associations and Gaussian end points: what its equations assume.
class LinesKnownRun {
 public:
  LinesKnownRun(const slam::WallFilterOptions& options, const LinesWorld& world, unsigned seed)
      : options_(options), world_(world), random_(seed), index_of_(world.edges.size(), -1) {}

  /// The walls within `range_m` whose free side the robot is on, whole, with the noise an extracted
  /// wall would state. Occlusion is not looked at: every wall is seen through.
  std::vector<slam::ObservedWall> observe(const Pose2& truth,
                                          double range_m,
                                          std::vector<slam::WallMatch>& matches) {
    std::normal_distribution<double> normal;
    std::vector<slam::ObservedWall> seen;
    matches.clear();
    for (std::size_t e = 0; e < world_.edges.size(); ++e) {
      const Eigen::Vector2d a = truth.inverse() * world_.edges[e].start_m;
      const Eigen::Vector2d b = truth.inverse() * world_.edges[e].end_m;
      const Eigen::Vector2d way = b - a;
      const Eigen::Vector2d n = Eigen::Vector2d(-way.y(), way.x()).normalized();
      if (n.dot(-a) < 0.1 || std::min(a.norm(), b.norm()) > range_m) continue;
      slam::ObservedWall wall;
      wall.across_sigma_m = 0.005;
      wall.direction_sigma_rad = 0.01 / std::max(0.3, way.norm());
      wall.start_sigma_m = wall.end_sigma_m = 0.02;
      wall.start_seen = wall.end_seen = true;
      wall.num_points = 20;
      wall.direction_rad =
          std::atan2(way.y(), way.x()) + wall.direction_sigma_rad * normal(random_);
      wall.center_m = 0.5 * (a + b) + wall.across_sigma_m * normal(random_) * n;
      const double half = 0.5 * way.norm();
      wall.start_m = wall.center_m + (-half + wall.start_sigma_m * normal(random_)) * wall.along();
      wall.end_m = wall.center_m + (half + wall.end_sigma_m * normal(random_)) * wall.along();
      seen.push_back(wall);
      matches.push_back({index_of_[e], 0.0});
      edges_.push_back(static_cast<int>(e));
    }
    return seen;
  }

  /// Called with (filter, truth, whether walls were added) after each step.
  template <class Visitor>
  void run(const std::vector<Eigen::Vector2d>& waypoints_m, const Visitor& visit) {
    LinesOdometryErrors errors;
    errors.distance_part = options_.motion.distance_sigma_part;
    errors.heading_part = options_.motion.heading_sigma_part;
    errors.heading_rad_per_m = options_.motion.heading_sigma_rad_per_m;
    errors.floor_m = options_.motion.floor_m;
    errors.floor_rad = options_.motion.floor_rad;
    const LinesDrive tour = drive(waypoints_m, 0.25, 0.2, errors, random_);
    std::normal_distribution<double> normal;
    const Pose2& start = tour.world_from_robot[0];
    // The filter's first pose is off by what it says of it.
    slam::WallFilter filter(options_,
                            {start.x_m + options_.start_sigma_m * normal(random_),
                             start.y_m + options_.start_sigma_m * normal(random_),
                             start.theta_rad + options_.start_sigma_rad * normal(random_)});
    std::vector<slam::WallMatch> matches;
    for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
      if (i > 0) filter.predict(tour.odometry_steps[i - 1]);
      edges_.clear();
      const auto seen = observe(tour.world_from_robot[i], 6.0, matches);
      filter.correct(seen, matches);
      const int added = filter.add_new(seen, matches);
      for (std::size_t k = 0; k < seen.size(); ++k) {
        index_of_[static_cast<std::size_t>(edges_[k])] = matches[k].wall;
      }
      visit(filter, tour.world_from_robot[i], added > 0);
    }
  }

 private:
  slam::WallFilterOptions options_;
  LinesWorld world_;
  std::mt19937 random_;
  std::vector<int> index_of_;
  std::vector<int> edges_;
};

}  // namespace marco::testing
