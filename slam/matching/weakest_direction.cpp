#include "slam/matching/weakest_direction.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace marco::slam {
namespace {

// Standard deviation of the normals of a scan's points [rad].
constexpr double kNormalSigma = 0.06;

// Where a distance counts in full, in standard deviations of the kernel; as far as a match reaches.
constexpr double kReachSigmas = 3.0;

double truncated_cost(const Correspondences& points, const Pose2& pose, double reach_m) {
  std::vector<float> distances_m;
  points.distances_m(pose, distances_m);
  double sum = 0.0;
  for (const float distance_m : distances_m) {
    const double d = std::isnan(distance_m) ? reach_m : static_cast<double>(distance_m);
    sum += std::min(reach_m * reach_m, d * d);
  }
  return sum;
}

// Half the second difference of the cost over the reach.
double information_seen(const SurfelMap& map,
                        Correspondences points,
                        const Pose2& pose,
                        const Eigen::Vector2d& direction,
                        double reach_m) {
  double information = -truncated_cost(points, pose, reach_m);
  for (const double step_m : {-reach_m, reach_m}) {
    const Pose2 moved{pose.x_m + step_m * direction.x(), pose.y_m + step_m * direction.y(),
                      pose.theta_rad};
    points.associate(map, moved);
    information += 0.5 * truncated_cost(points, moved, reach_m);
  }
  return information / (reach_m * reach_m);
}

}  // namespace

WeakestDirection::WeakestDirection(const SurfelMap& map,
                                   const Correspondences& points,
                                   const Pose2& centre_from_robot,
                                   double sigma_m)
    : sum_(points.sum(centre_from_robot, sigma_m).matrix()) {
  const double turn = sum_(2, 2) > 0.0 ? 1.0 / sum_(2, 2) : 0.0;
  const double xx = sum_(0, 0) - turn * sum_(0, 2) * sum_(0, 2);
  const double xy = sum_(0, 1) - turn * sum_(0, 2) * sum_(1, 2);
  const double yy = sum_(1, 1) - turn * sum_(1, 2) * sum_(1, 2);
  information = std::max(0.0, 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy));
  const double angle = 0.5 * std::atan2(-2.0 * xy, yy - xx);
  direction = {std::cos(angle), std::sin(angle)};
  const Eigen::Vector2d across(-direction.y(), direction.x());
  const double of_normals =
      kNormalSigma * kNormalSigma * across.dot(sum_.topLeftCorner<2, 2>() * across);
  const double of_cost = information - information_seen(map, points, centre_from_robot, direction,
                                                        kReachSigmas * sigma_m);
  by_noise = std::min(information, std::max(of_normals, of_cost));
}

Eigen::Matrix3d WeakestDirection::without_noise() const {
  Eigen::Matrix3d honest = sum_;
  honest.topLeftCorner<2, 2>() -= by_noise * direction * direction.transpose();
  return honest;
}

}  // namespace marco::slam
