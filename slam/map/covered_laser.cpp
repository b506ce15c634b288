#include "slam/map/covered_laser.hpp"

#include <algorithm>

#include "slam/front_end/match_gates.hpp"
#include "slam/map/range_view.hpp"

namespace marco::slam {
namespace {

// The last ones look ahead, and where the robot has just been.
constexpr std::size_t kViews = 5;

Seen look_at(const Eigen::Vector2d& point_in_world,
             std::span<const Keyframe> keys,
             const std::vector<RangeView>& views) {
  Seen result = Seen::nothing;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Seen seen = views[i].look_at(keys[i].world_from_robot.inverse() * point_in_world);
    if (seen == Seen::as_wall) return seen;
    if (seen == Seen::as_free) result = seen;
  }
  return result;
}

}  // namespace

bool laser_is_covered(const Points2& hits_in_robot,
                      const Eigen::Vector2d& sensor_in_robot,
                      std::span<const Pose2> world_from_robot,
                      const std::vector<Keyframe>& keys,
                      bool was_covered) {
  using namespace match_gates;
  const auto part = [&](double of_all) {
    return static_cast<Eigen::Index>(of_all * static_cast<double>(hits_in_robot.cols()));
  };
  const Eigen::Index near =
      ((hits_in_robot.colwise() - sensor_in_robot).colwise().norm().array() < kCoverWithinM)
          .count();
  if (keys.empty() || near <= part(kCoveredPart)) return false;
  const auto last = std::span(keys).last(std::min(keys.size(), kViews));
  const std::vector<RangeView> views(last.begin(), last.end());
  return std::all_of(world_from_robot.begin(), world_from_robot.end(), [&](const Pose2& place) {
    Eigen::Index free = 0, walls = 0;
    for (const auto& hit : hits_in_robot.colwise()) {
      const Seen seen = look_at(place * Eigen::Vector2d(hit), last, views);
      free += seen == Seen::as_free ? 1 : 0;
      walls += seen == Seen::as_wall ? 1 : 0;
    }
    return free > part(kCoverFreePart) || (was_covered && walls <= part(kCoveredPart));
  });
}

}  // namespace marco::slam
