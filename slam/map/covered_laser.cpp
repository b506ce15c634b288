#include "slam/map/covered_laser.hpp"

#include <algorithm>

#include "slam/front_end/match_gates.hpp"
#include "slam/map/range_view.hpp"

namespace marco::slam {
namespace {

// The last ones look ahead, and where the robot has just been.
constexpr std::size_t kViews = 5;

bool is_seen_as_free(const Eigen::Vector2d& point_in_world,
                     std::span<const Keyframe> keys,
                     const std::vector<RangeView>& views) {
  bool free = false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Seen seen = views[i].look_at(keys[i].world_from_robot.inverse() * point_in_world);
    if (seen == Seen::as_wall) return false;
    free = free || seen == Seen::as_free;
  }
  return free;
}

}  // namespace

bool laser_is_covered(const Points2& hits_in_robot,
                      const Eigen::Vector2d& sensor_in_robot,
                      std::span<const Pose2> world_from_robot,
                      const std::vector<Keyframe>& keys) {
  using namespace match_gates;
  const auto most =
      static_cast<Eigen::Index>(kCoveredPart * static_cast<double>(hits_in_robot.cols()));
  const Eigen::Index near =
      ((hits_in_robot.colwise() - sensor_in_robot).colwise().norm().array() < kCoverWithinM)
          .count();
  if (keys.empty() || near <= most) return false;
  const auto last = std::span(keys).last(std::min(keys.size(), kViews));
  const std::vector<RangeView> views(last.begin(), last.end());
  return std::all_of(world_from_robot.begin(), world_from_robot.end(), [&](const Pose2& place) {
    Eigen::Index free = 0;
    for (const auto& hit : hits_in_robot.colwise()) {
      free += is_seen_as_free(place * Eigen::Vector2d(hit), last, views) ? 1 : 0;
    }
    return free > most;
  });
}

}  // namespace marco::slam
