#include "slam/session/merge_maps.hpp"

#include "lcm_tools/base/check.hpp"
#include "slam/session/mending.hpp"

namespace marco::slam {

PoseGraphEdge edge_to(const FrozenMap& map, const FoundPlace& place, int newest_key) {
  PoseGraphEdge edge;
  edge.from = place.nearest_key;
  edge.to = newest_key;
  edge.from_from_to =
      between(map.keys()[static_cast<std::size_t>(place.nearest_key)].world_from_robot,
              place.map_from_robot);
  edge.information = information_of(rotated(place.covariance, -place.map_from_robot.theta_rad));
  return edge;
}

std::optional<FoundSession> find_session(FrozenMap& map,
                                         const std::vector<Keyframe>& keys,
                                         const LocalizerOptions& options) {
  SessionFinder finder(map, options);
  std::vector<Keyframe> session;
  for (const Keyframe& key : keys) {
    session.push_back(key);
    if (const auto place = finder.look(session)) {
      return FoundSession{*place, static_cast<int>(session.size()) - 1};
    }
  }
  return std::nullopt;
}

SavedMap merge_maps(std::vector<SavedMap> maps,
                    const SlamOptions& slam_options,
                    const LocalizerOptions& localizer_options,
                    std::vector<std::size_t>& not_found) {
  require(!maps.empty(), "there is no map to merge");
  Slam slam(slam_options);
  slam.restore(maps.front().slam);
  SavedMap merged = {maps.front().options, maps.front().session_starts, {}};
  for (std::size_t i = 1; i < maps.size(); ++i) {
    FrozenMap frozen(slam.keys(), localizer_options, slam_options);
    const auto found = find_session(frozen, maps[i].slam.keyframes.keys, localizer_options);
    if (!found) {
      not_found.push_back(i);
      continue;
    }
    const auto scans_before = static_cast<int64_t>(slam.state().path.scans.size());
    slam.join(maps[i].slam, edge_to(frozen, found->place, found->newest_key));
    for (const int64_t start : maps[i].session_starts) {
      merged.session_starts.push_back(scans_before + start);
    }
  }
  slam.finish();
  mend(slam);
  merged.slam = slam.state();
  return merged;
}

}  // namespace marco::slam
