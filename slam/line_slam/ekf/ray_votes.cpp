#include "slam/line_slam/ekf/ray_votes.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

double positive_angle(double angle_rad) {
  const double angle = normalize_angle(angle_rad);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

// Calls take(beam, place along the wall, range where the beam meets the wall, margin of that) for
// the beams that cross it.
template <class Take>
void for_each_ray(const ScanInRobot& scan, const Eigen::Vector4d& wall_in_robot, const Take& take) {
  const Eigen::Vector2d start = wall_in_robot.head<2>() - scan.sensor_m;
  const Eigen::Vector2d way = wall_in_robot.tail<2>() - wall_in_robot.head<2>();
  const Eigen::Vector2d u = way.normalized(), n = turned_left(u);
  const double offset_m = n.dot(start);
  const Eigen::Vector2d from = offset_m < 0.0 ? start : Eigen::Vector2d(start + way);
  const Eigen::Vector2d to = offset_m < 0.0 ? Eigen::Vector2d(start + way) : start;
  const double first_rad = positive_angle(std::atan2(from.y(), from.x()) - scan.first_bearing_rad);
  const double span_rad = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  const double step_rad = scan.bearing_step_rad;
  const int count = static_cast<int>(span_rad / step_rad);
  const int circle = static_cast<int>(std::lround(2.0 * std::numbers::pi / step_rad));
  constexpr double kGrazing = 0.2;  // sine of the angle below which a ray proves nothing
  for (int k = 0; k < count; ++k) {
    int index = static_cast<int>(std::ceil(first_rad / step_rad)) + k;
    if (index >= circle) index -= circle;
    if (index >= static_cast<int>(scan.beams.size())) continue;
    const Beam& beam = scan.beams[static_cast<std::size_t>(index)];
    if (!beam.returned) continue;
    const Eigen::Vector2d ray = (beam.hit_m - scan.sensor_m) / beam.range_m;
    const double sine = n.dot(ray);
    if (std::abs(sine) < kGrazing) continue;
    const double range_m = offset_m / sine;
    take(static_cast<std::size_t>(index), u.dot(range_m * ray - start), range_m,
         0.08 + 0.02 * range_m);
  }
}

}  // namespace

void vote_by_rays(const ScanInRobot& scan,
                  const Eigen::Vector4d& wall_in_robot,
                  double pose_margin_m,
                  WallEvidence& evidence) {
  for_each_ray(scan, wall_in_robot, [&](std::size_t index, double at_m, double range_m, double m) {
    const double beyond_m = scan.beams[index].range_m - range_m, margin_m = m + pose_margin_m;
    if (beyond_m > margin_m) evidence.vote_passed(at_m);
    if (std::abs(beyond_m) <= margin_m) evidence.vote_hit(at_m);
  });
}

void vote_for_nearest(const ScanInRobot& scan, const std::vector<WallSeen>& walls) {
  constexpr double kSameFacing = 0.95;  // cosine
  struct Nearest {
    double distance_m = std::numeric_limits<double>::infinity();
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
  };
  const auto along_of = [](const WallSeen& wall) -> Eigen::Vector2d {
    return (wall.in_robot.tail<2>() - wall.in_robot.head<2>()).normalized();
  };
  std::vector<Nearest> nearest(scan.beams.size());
  for (const WallSeen& wall : walls) {
    for_each_ray(scan, wall.in_robot, [&](std::size_t index, double, double range_m, double) {
      const double distance_m = std::abs(scan.beams[index].range_m - range_m);
      if (distance_m < nearest[index].distance_m) nearest[index] = {distance_m, along_of(wall)};
    });
  }
  for (const WallSeen& wall : walls) {
    for_each_ray(
        scan, wall.in_robot, [&](std::size_t index, double at_m, double range_m, double margin_m) {
          const double beyond_m = scan.beams[index].range_m - range_m;
          if (beyond_m < -margin_m) return;
          const Nearest& best = nearest[index];
          const bool rivalled =
              std::abs(beyond_m) > best.distance_m && along_of(wall).dot(best.along) > kSameFacing;
          if (beyond_m > margin_m || rivalled) {
            wall.evidence->vote_passed(at_m);
          } else {
            wall.evidence->vote_hit(at_m);
          }
        });
  }
}

}  // namespace marco::slam
