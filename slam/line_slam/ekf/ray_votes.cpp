#include "slam/line_slam/ekf/ray_votes.hpp"

#include <cmath>
#include <numbers>

#include "common/pose2.hpp"

namespace marco::slam {
namespace {

double positive_angle(double angle_rad) {
  const double angle = normalize_angle(angle_rad);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

}  // namespace

void vote_by_rays(const ScanInRobot& scan,
                  const Eigen::Vector4d& wall_in_robot,
                  double pose_margin_m,
                  WallEvidence& evidence) {
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
    int beam_index = static_cast<int>(std::ceil(first_rad / step_rad)) + k;
    if (beam_index >= circle) beam_index -= circle;
    if (beam_index >= static_cast<int>(scan.beams.size())) continue;
    const Beam& beam = scan.beams[static_cast<std::size_t>(beam_index)];
    if (!beam.returned) continue;
    const Eigen::Vector2d ray = (beam.hit_m - scan.sensor_m) / beam.range_m;
    const double sine = n.dot(ray);
    if (std::abs(sine) < kGrazing) continue;
    const double range_m = offset_m / sine;
    const double at_m = u.dot(range_m * ray - start);
    const double margin_m = 0.08 + 0.02 * range_m + pose_margin_m;
    if (beam.range_m > range_m + margin_m) evidence.vote_passed(at_m);
    if (std::abs(beam.range_m - range_m) <= margin_m) evidence.vote_hit(at_m);
  }
}

}  // namespace marco::slam
