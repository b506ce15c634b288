#pragma once

#include <vector>

#include "slam/map/range_view.hpp"

namespace marco::slam {

/// What a visit to a place could see: the views of some of its keyframes, joined. Const members are
/// safe from several threads.
class PlaceView {
 public:
  /// @param keys  outlive the view
  explicit PlaceView(const std::vector<Keyframe>& keys);

  /// A wall that one keyframe saw there, else free space that one saw.
  /// @param point_m  world
  Seen look_at(const Eigen::Vector2d& point_m) const;

  /// For each point, whether the visit could see it: on a wall that it saw, or in free space.
  /// @param points  2xN [m], seen from `world_from_points`
  std::vector<bool> sees(const Points2& points, const Pose2& world_from_points) const;

 private:
  struct View {
    Pose2 robot_from_world;
    RangeView beams;
  };
  std::vector<View> views_;
};

}  // namespace marco::slam
