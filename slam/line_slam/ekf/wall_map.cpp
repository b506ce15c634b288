#include <algorithm>
#include <cmath>
#include <numbers>

#include "slam/line_slam/ekf/joint_compatibility.hpp"
#include "slam/line_slam/ekf/wall_filter.hpp"

namespace marco::slam {
namespace {

double positive_angle(double angle_rad) {
  const double angle = normalize_angle(angle_rad);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

}  // namespace

void WallFilter::extend(const std::vector<ObservedWall>& observed,
                        const std::vector<WallMatch>& matches) {
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (matches[i].wall < 0) continue;
    const auto index = static_cast<std::size_t>(matches[i].wall);
    move_end(index, observed[i], true);
    move_end(index, observed[i], false);
  }
}

// Along the wall the new end is where the scan saw it, across it lies on the map's line: the union
// of 5.3.1 as a change of the state, p' = (1 - part) p1 + part p2.
bool WallFilter::move_end(std::size_t index, const ObservedWall& observed, bool at_start) {
  MapWall& wall = walls_[index];
  const Eigen::Vector4d mean = wall_mean(index);
  const Eigen::Vector2d way = mean.tail<2>() - mean.head<2>();
  const double length_m = way.norm();
  const Eigen::Vector2d u = way / length_m;
  const Segment seen = seen_in_world(observed);
  const double at_m = u.dot((at_start ? seen.start_m : seen.end_m) - mean.head<2>());
  const double beyond_m = at_start ? -at_m : at_m - length_m;
  bool& map_end_seen = at_start ? wall.start_seen : wall.end_seen;
  const bool end_seen = at_start ? observed.start_seen : observed.end_seen;
  // A cut-off end gives way to a true one; else only what is clearly farther counts.
  const bool becomes_true = end_seen && !map_end_seen && beyond_m > -options_.end_distance_m;
  const double least_m = map_end_seen ? end_limit_m(observed, index) : options_.end_distance_m;
  if (!becomes_true && beyond_m <= least_m) return false;

  const double part = at_m / length_m;
  const double sigma_m = at_start ? observed.start_sigma_m : observed.end_sigma_m;
  const Eigen::Matrix2d along = u * u.transpose();
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - along;
  const Eigen::Index row = at_start ? 0 : 2;
  const auto moved_of = [&](const Eigen::Vector4d& ends) -> Eigen::Vector2d {
    return (1.0 - part) * ends.head<2>() + part * ends.tail<2>();
  };
  Eigen::Vector4d new_mean = mean, new_first = state_.first_estimate(wall.block);
  const Eigen::Vector2d moved_first = moved_of(new_first);
  new_mean.segment<2>(row) = moved_of(mean);
  new_first.segment<2>(row) = moved_first;

  SparseRows change;
  change.resize(4);
  change.num_blocks = 2;
  change.blocks = {0, wall.block, 0};
  change.jacobian.block<4, 4>(0, 4).setIdentity();
  change.jacobian.block<2, 2>(row, 4) = (1.0 - part) * across;
  change.jacobian.block<2, 2>(row, 6) = part * across;
  change.jacobian.block<2, 2>(row, 0) = along;
  change.jacobian.block<2, 1>(row, 2) =
      along * turned_left(moved_first - state_.first_estimate(0).head<2>());
  change.noise.block<2, 2>(row, row) = sigma_m * sigma_m * along;
  state_.replace(wall.block, change, new_mean, new_first);
  wall.evidence.set_extent(at_start ? beyond_m : 0.0, length_m + beyond_m);
  map_end_seen = end_seen;
  return true;
}

// The offsets of b's ends from a's line, measured to be 0.
SparseRows WallFilter::line_rows(std::size_t a, std::size_t b) const {
  const int block_a = walls_[a].block, block_b = walls_[b].block;
  const Eigen::Vector4d first_a = state_.first_estimate(block_a);
  const Eigen::Vector4d first_b = state_.first_estimate(block_b);
  const Eigen::Vector4d mean_a = state_.mean(block_a), mean_b = state_.mean(block_b);
  const Eigen::Vector2d way_first = first_a.tail<2>() - first_a.head<2>();
  const Eigen::Vector2d n_first = turned_left(way_first).normalized();
  const Eigen::Vector2d n =
      turned_left(Eigen::Vector2d(mean_a.tail<2>() - mean_a.head<2>())).normalized();
  SparseRows rows;
  rows.resize(2);
  rows.num_blocks = 2;
  rows.blocks = {block_a, block_b, 0};
  for (Eigen::Index i = 0; i < 2; ++i) {
    const double part =
        way_first.dot(first_b.segment<2>(2 * i) - first_a.head<2>()) / way_first.squaredNorm();
    rows.jacobian.block<1, 2>(i, 0) = -(1.0 - part) * n_first.transpose();
    rows.jacobian.block<1, 2>(i, 2) = -part * n_first.transpose();
    rows.jacobian.block<1, 2>(i, 4 + 2 * i) = n_first.transpose();
    rows.innovation(i) = -n.dot(mean_b.segment<2>(2 * i) - mean_a.head<2>());
    rows.noise(i, i) = options_.join_sigma_m * options_.join_sigma_m;
  }
  return rows;
}

void WallFilter::join(std::size_t a, std::size_t b) {
  if (segment(b).end_m == segment(b).start_m) return remove(b);
  state_.correct(line_rows(a, b));
  state_.finish_corrections();
  MapWall& kept = walls_[a];
  const MapWall& other = walls_[b];
  const Eigen::Vector4d mean_a = wall_mean(a), mean_b = wall_mean(b);
  const Eigen::Vector4d first_a = state_.first_estimate(kept.block);
  const Eigen::Vector4d first_b = state_.first_estimate(other.block);
  const Eigen::Vector2d way = mean_a.tail<2>() - mean_a.head<2>();
  const double length_m = way.norm();
  const double start_m = way.dot(mean_b.head<2>() - mean_a.head<2>()) / length_m;
  const double end_m = way.dot(mean_b.tail<2>() - mean_a.head<2>()) / length_m;
  const bool take_start = start_m<0.0, take_end = end_m> length_m;

  SparseRows choice;
  choice.resize(4);
  choice.num_blocks = 2;
  choice.blocks = {kept.block, other.block, 0};
  choice.jacobian.block<2, 2>(0, take_start ? 4 : 0).setIdentity();
  choice.jacobian.block<2, 2>(2, take_end ? 6 : 2).setIdentity();
  Eigen::Vector4d mean, first;
  mean << (take_start ? mean_b : mean_a).head<2>(), (take_end ? mean_b : mean_a).tail<2>();
  first << (take_start ? first_b : first_a).head<2>(), (take_end ? first_b : first_a).tail<2>();
  state_.replace(kept.block, choice, mean, first);

  const double before_m = take_start ? -start_m : 0.0;
  kept.evidence.set_extent(before_m, (mean.tail<2>() - mean.head<2>()).norm());
  kept.evidence.merge(other.evidence, take_start ? 0.0 : start_m);
  if (take_start) kept.start_seen = other.start_seen;
  if (take_end) kept.end_seen = other.end_seen;
  kept.times_seen = std::max(kept.times_seen, other.times_seen);
  kept.id = std::min(kept.id, other.id);
  remove(b);
}

int WallFilter::join_similar(const std::vector<WallMatch>& matches) {
  const double gate = chi_square_limit(2, options_.gate_probability);
  std::vector<int64_t> seen;
  for (const WallMatch& match : matches) {
    if (match.wall >= 0) seen.push_back(walls_[static_cast<std::size_t>(match.wall)].id);
  }
  int joined = 0;
  for (const int64_t id : seen) {
    for (std::size_t j = 0; j < walls_.size(); ++j) {
      const auto at = std::find_if(walls_.begin(), walls_.end(),
                                   [id](const MapWall& wall) { return wall.id == id; });
      if (at == walls_.end()) break;
      const auto i = static_cast<std::size_t>(at - walls_.begin());
      if (i == j || !state_.is_active(walls_[j].block)) continue;
      const Segment a = segment(i), b = segment(j);
      if (!slam::similar(a, b, options_.similar)) continue;
      const bool first_longer =
          (a.end_m - a.start_m).squaredNorm() >= (b.end_m - b.start_m).squaredNorm();
      const std::size_t longer = first_longer ? i : j, shorter = first_longer ? j : i;
      if (individual_distance2(state_, {0, 0, line_rows(longer, shorter)}) > gate) continue;
      join(longer, shorter);
      ++joined;
      j = static_cast<std::size_t>(-1);  // indices changed: look at all again
    }
  }
  return joined;
}

void WallFilter::vote(const ScanInRobot& scan, MapWall& wall) const {
  const Eigen::Vector4d seen = seen_from_robot(state_.mean(0).head<3>(), state_.mean(wall.block));
  const Eigen::Vector2d start = seen.head<2>() - scan.sensor_m;
  const Eigen::Vector2d way = seen.tail<2>() - seen.head<2>();
  const Eigen::Vector2d u = way.normalized(), n = turned_left(u);
  const double offset_m = n.dot(start);
  const Eigen::Vector2d from = offset_m < 0.0 ? start : Eigen::Vector2d(start + way);
  const Eigen::Vector2d to = offset_m < 0.0 ? Eigen::Vector2d(start + way) : start;
  const double first_rad = positive_angle(std::atan2(from.y(), from.x()) - scan.first_bearing_rad);
  const double span_rad = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  const double step_rad = scan.bearing_step_rad;
  const int count = static_cast<int>(span_rad / step_rad);
  const int circle = static_cast<int>(std::lround(2.0 * std::numbers::pi / step_rad));
  const Eigen::Matrix3d p = robot_covariance();
  const double pose_m = 2.0 * std::sqrt(std::max(p(0, 0), p(1, 1)));
  constexpr double kGrazing = 0.2;  // sine of the angle below which a ray tells nothing sure
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
    const double margin_m = 0.08 + 0.02 * range_m + pose_m;
    if (beam.range_m > range_m + margin_m) wall.evidence.vote_passed(at_m);
    if (std::abs(beam.range_m - range_m) <= margin_m) wall.evidence.vote_hit(at_m);
  }
}

int WallFilter::judge(const ScanInRobot& scan) {
  if (scan.bearing_step_rad <= 0.0) return 0;
  const Eigen::Vector2d robot_m = state_.mean(0).head<2>();
  int removed = 0;
  for (std::size_t i = walls_.size(); i-- > 0;) {
    MapWall& wall = walls_[i];
    if (!state_.is_active(wall.block)) continue;
    const Eigen::Vector4d mean = state_.mean(wall.block);
    const double far_m = options_.active_radius_m + (mean.tail<2>() - mean.head<2>()).norm();
    if ((mean.head<2>() - robot_m).norm() > far_m) continue;
    vote(scan, wall);
    wall.evidence.count_votes(options_.evidence);
    if (wall.evidence.existence() >= options_.evidence.forget_probability) continue;
    remove(i);
    ++removed;
  }
  return removed;
}

Walls WallFilter::plan(int64_t min_times_seen, double min_length_m) {
  Walls plan;
  for (const MapWall& wall : walls_) {
    if (wall.times_seen < min_times_seen) continue;
    const Eigen::Vector4d mean = state_.mean(wall.block);
    const Eigen::Matrix4d covariance = state_.marginal(wall.block);
    const double length_m = (mean.tail<2>() - mean.head<2>()).norm();
    for (const WallEvidence::Run& run : wall.evidence.runs(options_.evidence)) {
      const double to_m = std::min(run.to_m, length_m);
      if (to_m - run.from_m < min_length_m) continue;
      const double from_part = run.from_m / length_m, to_part = to_m / length_m;
      Eigen::Matrix4d cut = Eigen::Matrix4d::Zero();
      cut.topLeftCorner<2, 2>().diagonal().setConstant(1.0 - from_part);
      cut.topRightCorner<2, 2>().diagonal().setConstant(from_part);
      cut.bottomLeftCorner<2, 2>().diagonal().setConstant(1.0 - to_part);
      cut.bottomRightCorner<2, 2>().diagonal().setConstant(to_part);
      const Eigen::Vector4d ends = cut * mean;
      Wall piece;
      piece.id = wall.id;
      piece.start_m = ends.head<2>();
      piece.end_m = ends.tail<2>();
      piece.covariance = cut * covariance * cut.transpose();
      piece.existence = wall.evidence.existence();
      piece.times_seen = wall.times_seen;
      piece.start_seen = wall.start_seen || run.from_m > 0.0;
      piece.end_seen = wall.end_seen || to_m < length_m;
      plan.push_back(std::move(piece));
    }
  }
  return plan;
}

}  // namespace marco::slam
