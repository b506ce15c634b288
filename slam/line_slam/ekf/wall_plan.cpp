#include "slam/line_slam/ekf/wall_plan.hpp"

#include <algorithm>
#include <cmath>

#include "slam/line_slam/ekf/circle_evidence.hpp"

namespace marco::slam {

Walls plan_of(const WallMap& map, int64_t min_times_seen, double min_length_m) {
  Walls plan;
  for (const MapWall& wall : map.walls()) {
    if (wall.times_seen < min_times_seen) continue;
    const Eigen::Vector4d mean = map.state().mean(wall.block);
    const Eigen::Matrix4d covariance = map.state().covariance(wall.block, wall.block);
    const double length_m = (mean.tail<2>() - mean.head<2>()).norm();
    for (const WallEvidence::Run& run : wall.evidence.runs(map.options().evidence)) {
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

void drop_posts_on_walls(const Walls& plan, RoundWalls& posts) {
  // Part of the radius. In eight simulated drives no wall cuts a true column; of four corners that
  // were taken for posts, two are cut along 1.1 and 1.4 radii.
  constexpr double kThrough = 1.0;
  const auto runs_through = [](const Wall& wall, const RoundWall& post) {
    const double length_m = wall.length_m();
    if (!(length_m > 0.0)) return false;
    const Eigen::Vector2d along = (wall.end_m - wall.start_m) / length_m;
    const Eigen::Vector2d to_m = post.centre_m - wall.start_m;
    const double at_m = along.dot(to_m), off2 = to_m.squaredNorm() - at_m * at_m;
    const double half_m = std::sqrt(std::max(0.0, post.radius_m * post.radius_m - off2));
    const double inside_m = std::min(length_m, at_m + half_m) - std::max(0.0, at_m - half_m);
    return inside_m >= kThrough * post.radius_m;
  };
  std::erase_if(posts, [&](const RoundWall& post) {
    return post.is_whole() && post.radius_m <= kLargestPostM &&
           std::any_of(plan.begin(), plan.end(),
                       [&](const Wall& wall) { return runs_through(wall, post); });
  });
}

}  // namespace marco::slam
