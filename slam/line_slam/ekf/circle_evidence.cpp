#include "slam/line_slam/ekf/circle_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::slam {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

SeenArc::SeenArc(const WallEvidenceOptions& options, double from, double span, double radius_m)
    : from_rad(normalize_angle(from)),
      span_rad(span),
      scale_m(radius_m),
      evidence(options, span * radius_m) {}

void SeenArc::grow(double from, double span) {
  const double after = turn_between(from_rad, from);
  const double before = after - kTurn;
  const double span_after = std::max(span_rad, after + span);
  const double span_before = std::max(span_rad, before + span) - before;
  if (std::min(span_after, span_before) >= kTurn) {
    span_rad = kTurn;
    evidence.set_extent(0.0, scale_m * span_rad);
  } else if (span_after <= span_before) {
    span_rad = span_after;
    evidence.set_extent(0.0, scale_m * span_rad);
  } else {
    from_rad = normalize_angle(from_rad + before);
    span_rad = span_before;
    evidence.set_extent(-scale_m * before, scale_m * span_rad);
  }
}

void SeenArc::merge(const SeenArc& other) {
  grow(other.from_rad, other.span_rad);
  const double start_m = scale_m * turn_between(from_rad, other.from_rad);
  evidence.merge(other.evidence, start_m);
  // What lies beyond the circle's beginning.
  if (start_m + scale_m * other.span_rad > scale_m * kTurn) {
    evidence.merge(other.evidence, start_m - scale_m * kTurn);
  }
}

void SeenArc::vote_by_rays(const ScanInRobot& scan,
                           const Pose2& world_from_robot,
                           const Eigen::Vector3d& circle,
                           bool from_inside,
                           double pose_margin_m) {
  constexpr double kGrazing = 0.2;  // sine of the angle below which a ray proves nothing
  const Eigen::Vector2d centre_m = world_from_robot.inverse() * Eigen::Vector2d(circle.head<2>());
  const Eigen::Vector2d to_m = centre_m - scan.sensor_m;
  const double radius_m = circle[2], radius2 = radius_m * radius_m;
  const double through_m = radius_m <= kLargestPostM ? 2.0 * radius_m : 0.0;
  const auto look = [&](const Beam& beam) {
    if (!beam.returned) return;
    const Eigen::Vector2d ray = (beam.hit_m - scan.sensor_m) / beam.range_m;
    const double along_m = ray.dot(to_m);
    const double inside2 = radius2 - (to_m - along_m * ray).squaredNorm();
    if (inside2 < kGrazing * kGrazing * radius2) return;
    const double range_m = along_m + (from_inside ? 1.0 : -1.0) * std::sqrt(inside2);
    if (range_m <= 0.0) return;
    const double beyond_m = beam.range_m - range_m;
    const double margin_m = 0.08 + 0.02 * range_m + pose_margin_m;
    const bool hit = std::abs(beyond_m) <= margin_m, passed = beyond_m > margin_m + through_m;
    if (!hit && !passed) return;
    const Eigen::Vector2d met_m = range_m * ray - to_m;
    const double direction = std::atan2(met_m.y(), met_m.x()) + world_from_robot.theta_rad;
    const double at_m = scale_m * turn_between(from_rad, direction);
    if (hit) evidence.vote_hit(at_m);
    if (passed) evidence.vote_passed(at_m);
  };
  // Only a cone of beams meets a circle from outside.
  constexpr int kSpareBeams = 3;  // the robot turns during a scan
  const auto beams = static_cast<int>(scan.beams.size());
  const double distance_m = to_m.norm();
  if (from_inside || distance_m <= radius_m || scan.bearing_step_rad <= 0.0) {
    for (const Beam& beam : scan.beams) look(beam);
    return;
  }
  const double half_rad = std::asin(radius_m / distance_m);
  const double begin_rad =
      turn_between(scan.first_bearing_rad, std::atan2(to_m.y(), to_m.x()) - half_rad);
  const int first = static_cast<int>(begin_rad / scan.bearing_step_rad) - kSpareBeams;
  const int count = static_cast<int>(2.0 * half_rad / scan.bearing_step_rad) + 2 * kSpareBeams + 2;
  const int whole = static_cast<int>(std::lround(kTurn / scan.bearing_step_rad));
  for (int i = first; i < first + count; ++i) {
    const int beam = (i % whole + whole) % whole;
    if (beam < beams) look(scan.beams[static_cast<std::size_t>(beam)]);
  }
}

std::vector<SeenArc::Run> SeenArc::standing(double radius_m,
                                            const WallEvidenceOptions& options) const {
  constexpr double kLeastLengthM = 0.3;  // a shorter piece of an arc is clutter
  std::vector<Run> found;
  for (const WallEvidence::Run& run : evidence.runs(options)) {
    found.push_back({from_rad + run.from_m / scale_m, (run.to_m - run.from_m) / scale_m});
  }
  if (found.empty()) return found;
  if (radius_m <= kLargestPostM) return {{from_rad, kTurn}};
  constexpr double kSame = 1e-6;  // rounding
  if (found.size() > 1 && span_rad >= kTurn - kSame) {
    const Run& last = found.back();
    const double beyond = turn_between(last.from_rad + last.span_rad, found.front().from_rad);
    if (beyond < kSame || beyond > kTurn - kSame) {
      found.front() = {last.from_rad, last.span_rad + found.front().span_rad};
      found.pop_back();
    }
  }
  std::erase_if(found,
                [radius_m](const Run& run) { return run.span_rad * radius_m < kLeastLengthM; });
  for (Run& run : found) {
    run.from_rad = normalize_angle(run.from_rad);
    run.span_rad = std::min(run.span_rad, kTurn);
  }
  return found;
}

}  // namespace marco::slam
