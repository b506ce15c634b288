#include "slam/map/place_view.hpp"

namespace marco::slam {

PlaceView::PlaceView(const std::vector<Keyframe>& keys) {
  views_.reserve(keys.size());
  for (const Keyframe& key : keys) {
    views_.push_back({key.world_from_robot.inverse(), RangeView(key)});
  }
}

Seen PlaceView::look_at(const Eigen::Vector2d& point_m) const {
  Seen seen = Seen::nothing;
  for (const View& view : views_) {
    const Seen by_one = view.beams.look_at(view.robot_from_world * point_m);
    if (by_one == Seen::as_wall) return by_one;
    if (by_one == Seen::as_free) seen = by_one;
  }
  return seen;
}

std::vector<bool> PlaceView::sees(const Points2& points, const Pose2& world_from_points) const {
  std::vector<bool> seen(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector2d point_m = points.col(i);
    seen[static_cast<std::size_t>(i)] = look_at(world_from_points * point_m) != Seen::nothing;
  }
  return seen;
}

}  // namespace marco::slam
