#include "slam/session/session_history.hpp"

#include <algorithm>
#include <utility>

#include "slam/session/merge_maps.hpp"

namespace marco::slam {

void SessionHistory::end_joined(std::size_t map_scans) {
  std::size_t scans = map_scans - first_own_scan_;
  for (const Part& part : parts_) scans -= part.is_apart ? 0 : part.scans;
  parts_.push_back({scans, false});
}

void SessionHistory::end_apart(std::size_t scans, SavedMap map) {
  if (!map.slam.keyframes.keys.empty()) apart_.push_back({{session_}, std::move(map)});
  parts_.push_back({scans, true});
}

void SessionHistory::group_apart(const SlamOptions& slam_options,
                                 const LocalizerOptions& localizer_options) {
  std::vector<Apart> groups;
  for (std::vector<Apart> left = std::move(apart_); !left.empty();) {
    std::vector<SavedMap> maps;
    maps.reserve(left.size());
    for (const Apart& one : left) maps.push_back(one.map);
    std::vector<std::size_t> not_found;
    Apart group;
    group.map = left.size() == 1
                    ? std::move(maps.front())
                    : merge_maps(std::move(maps), slam_options, localizer_options, not_found);
    std::vector<Apart> others;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const bool found = std::find(not_found.begin(), not_found.end(), i) == not_found.end();
      if (found) {
        group.sessions.insert(group.sessions.end(), left[i].sessions.begin(),
                              left[i].sessions.end());
      } else {
        others.push_back(std::move(left[i]));
      }
    }
    groups.push_back(std::move(group));
    left = std::move(others);
  }
  apart_ = std::move(groups);
}

std::vector<std::optional<Pose2>> SessionHistory::poses(
    const Trajectory& map, const std::optional<Trajectory>& alone) const {
  std::vector<std::optional<Pose2>> result;
  std::size_t next = first_own_scan_;
  for (const Part& part : parts_) {
    for (std::size_t i = 0; i < part.scans; ++i) {
      result.push_back(part.is_apart ? std::nullopt : std::optional(map[next++].world_from_robot));
    }
  }
  if (alone) {
    for (const StampedPose2& pose : *alone) result.emplace_back(pose.world_from_robot);
  } else {
    while (next < map.size()) result.emplace_back(map[next++].world_from_robot);
  }
  return result;
}

}  // namespace marco::slam
