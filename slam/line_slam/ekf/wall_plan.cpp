#include "slam/line_slam/ekf/wall_plan.hpp"

#include <algorithm>

namespace marco::slam {

Walls plan_of(WallMap& map, int64_t min_times_seen, double min_length_m) {
  Walls plan;
  for (const MapWall& wall : map.walls()) {
    if (wall.times_seen < min_times_seen) continue;
    const Eigen::Vector4d mean = map.state().mean(wall.block);
    const Eigen::Matrix4d covariance = map.state().marginal(wall.block);
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

}  // namespace marco::slam
