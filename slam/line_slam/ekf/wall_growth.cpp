#include "slam/line_slam/ekf/wall_growth.hpp"

#include <algorithm>
#include <cmath>

#include "slam/line_slam/ekf/joint_compatibility.hpp"

namespace marco::slam {
namespace {

enum class WallEnd { start, end };

// Along the wall the new end is where the scan saw it, across it lies on the map's line: the union
// of 5.3.1 as a change of the state, p' = (1 - part) p1 + part p2.
void move_end(WallMap& map, std::size_t index, const ObservedWall& observed, WallEnd which) {
  const bool at_start = which == WallEnd::start;
  const WallFilterOptions& options = map.options();
  EkfState& state = map.state();
  MapWall& wall = map.wall(index);
  const Eigen::Vector4d mean = map.mean(index);
  const Eigen::Vector2d way = mean.tail<2>() - mean.head<2>();
  const double length_m = way.norm();
  const Eigen::Vector2d u = way / length_m;
  const Segment seen = map.seen_in_world(observed);
  const double at_m = u.dot((at_start ? seen.start_m : seen.end_m) - mean.head<2>());
  const double beyond_m = at_start ? -at_m : at_m - length_m;
  bool& map_end_seen = at_start ? wall.start_seen : wall.end_seen;
  const bool end_seen = at_start ? observed.start_seen : observed.end_seen;
  // A cut-off end gives way to a true one; otherwise only what is clearly farther counts.
  const bool becomes_true = end_seen && !map_end_seen && beyond_m > -options.end_distance_m;
  const double least_m = map_end_seen ? map.end_limit_m(observed, index) : options.end_distance_m;
  if (!becomes_true && beyond_m <= least_m) return;

  const double part = at_m / length_m;
  const double sigma_m = at_start ? observed.start_sigma_m : observed.end_sigma_m;
  const Eigen::Matrix2d along = u * u.transpose();
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - along;
  const Eigen::Index row = at_start ? 0 : 2;
  const auto moved_of = [&](const Eigen::Vector4d& ends) -> Eigen::Vector2d {
    return (1.0 - part) * ends.head<2>() + part * ends.tail<2>();
  };
  Eigen::Vector4d new_mean = mean, new_first = state.first_estimate(wall.block);
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
      along * turned_left(moved_first - state.first_estimate(0).head<2>());
  change.noise.block<2, 2>(row, row) = sigma_m * sigma_m * along;
  state.replace(wall.block, change, new_mean, new_first);
  wall.evidence.set_extent(at_start ? beyond_m : 0.0, length_m + beyond_m);
  map_end_seen = end_seen;
}

// The offsets of b's ends from a's line, measured to be 0.
SparseRows collinearity(const WallMap& map, std::size_t a, std::size_t b) {
  const EkfState& state = map.state();
  const int block_a = map.wall(a).block, block_b = map.wall(b).block;
  const Eigen::Vector4d first_a = state.first_estimate(block_a);
  const Eigen::Vector4d first_b = state.first_estimate(block_b);
  const Eigen::Vector4d mean_a = map.mean(a), mean_b = map.mean(b);
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
    rows.noise(i, i) = map.options().join_sigma_m * map.options().join_sigma_m;
  }
  return rows;
}

double squared_length(const Segment& segment) {
  return (segment.end_m - segment.start_m).squaredNorm();
}

// Index of the wall with this id; map.size() when it was joined with another.
std::size_t index_of(const WallMap& map, int64_t id) {
  const auto at = std::find_if(map.walls().begin(), map.walls().end(),
                               [id](const MapWall& wall) { return wall.id == id; });
  return static_cast<std::size_t>(at - map.walls().begin());
}

}  // namespace

void extend_wall(WallMap& map, std::size_t index, const ObservedWall& observed) {
  move_end(map, index, observed, WallEnd::start);
  move_end(map, index, observed, WallEnd::end);
}

void join_walls(WallMap& map, std::size_t a, std::size_t b) {
  if (squared_length(map.segment(b)) == 0.0) return map.remove(b);
  EkfState& state = map.state();
  state.correct(collinearity(map, a, b));
  state.finish_corrections();
  MapWall& kept = map.wall(a);
  const MapWall& other = map.wall(b);
  const Eigen::Vector4d mean_a = map.mean(a), mean_b = map.mean(b);
  const Eigen::Vector4d first_a = state.first_estimate(kept.block);
  const Eigen::Vector4d first_b = state.first_estimate(other.block);
  const Eigen::Vector2d way = mean_a.tail<2>() - mean_a.head<2>();
  const double length_m = way.norm();
  const double start_m = way.dot(mean_b.head<2>() - mean_a.head<2>()) / length_m;
  const double end_m = way.dot(mean_b.tail<2>() - mean_a.head<2>()) / length_m;
  const bool take_start = start_m < 0.0;
  const bool take_end = end_m > length_m;

  SparseRows choice;
  choice.resize(4);
  choice.num_blocks = 2;
  choice.blocks = {kept.block, other.block, 0};
  choice.jacobian.block<2, 2>(0, take_start ? 4 : 0).setIdentity();
  choice.jacobian.block<2, 2>(2, take_end ? 6 : 2).setIdentity();
  Eigen::Vector4d mean, first;
  mean << (take_start ? mean_b : mean_a).head<2>(), (take_end ? mean_b : mean_a).tail<2>();
  first << (take_start ? first_b : first_a).head<2>(), (take_end ? first_b : first_a).tail<2>();
  state.replace(kept.block, choice, mean, first);

  const double before_m = take_start ? -start_m : 0.0;
  kept.evidence.set_extent(before_m, (mean.tail<2>() - mean.head<2>()).norm());
  kept.evidence.merge(other.evidence, take_start ? 0.0 : start_m);
  if (take_start) kept.start_seen = other.start_seen;
  if (take_end) kept.end_seen = other.end_seen;
  kept.times_seen = std::max(kept.times_seen, other.times_seen);
  kept.id = std::min(kept.id, other.id);
  map.remove(b);
}

int join_similar_walls(WallMap& map, const std::vector<WallMatch>& matches) {
  const double gate = chi_square_limit(2, map.options().gate_probability);
  std::vector<int64_t> seen;
  for (const WallMatch& match : matches) {
    if (match.wall >= 0) seen.push_back(map.wall(static_cast<std::size_t>(match.wall)).id);
  }
  int joined = 0;
  for (const int64_t id : seen) {
    for (std::size_t j = 0; j < map.size(); ++j) {
      const std::size_t i = index_of(map, id);
      if (i == map.size()) break;
      if (i == j) continue;
      const Segment a = map.segment(i), b = map.segment(j);
      if (!similar(a, b, map.options().similar)) continue;
      const bool first_longer = squared_length(a) >= squared_length(b);
      const std::size_t longer = first_longer ? i : j, shorter = first_longer ? j : i;
      const Candidate candidate{0, 0, collinearity(map, longer, shorter)};
      if (individual_distance2(map.state(), candidate) > gate) continue;
      join_walls(map, longer, shorter);
      ++joined;
      j = static_cast<std::size_t>(-1);  // indices changed: look at all again
    }
  }
  return joined;
}

}  // namespace marco::slam
