#pragma once

#include <optional>
#include <vector>

#include "slam/localization/saved_map.hpp"
#include "slam/localization/session_finder.hpp"

namespace marco::slam {

/// Where a recorded session is in a map.
struct FoundSession {
  FoundPlace place;
  int newest_key = 0;  ///< of the session, when it was found
};
/// @param keys  of the session. @returns nothing where it was found nowhere.
std::optional<FoundSession> find_session(FrozenMap& map,
                                         const std::vector<Keyframe>& keys,
                                         const LocalizerOptions& options);

/// The edge that ties a session to a map: its newest keyframe at the place where it was found.
PoseGraphEdge edge_to(const FrozenMap& map, const FoundPlace& place, int newest_key);

/// Joins saved maps of one building into the first. Each next one is searched in what is joined so
/// far, by its own path. @returns the merged map; @param not_found  gets the indices of those that
/// were found nowhere and left out.
SavedMap merge_maps(std::vector<SavedMap> maps,
                    const SlamOptions& slam,
                    const LocalizerOptions& localizer,
                    std::vector<std::size_t>& not_found);

}  // namespace marco::slam
