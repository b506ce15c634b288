#pragma once

#include <optional>
#include <vector>

#include "common/trajectory.hpp"
#include "slam/localization/frozen_map.hpp"
#include "slam/localization/saved_map.hpp"

namespace marco::slam {

/// Which scans came in which session, and the maps of sessions that were found nowhere.
class SessionHistory {
 public:
  /// Sessions found nowhere, as a map of their own: those found in one another are one.
  struct Apart {
    std::vector<int> sessions;  ///< counted from 1 on
    SavedMap map;
  };

  /// @param first_own_scan  scans of the map that was extended
  explicit SessionHistory(std::size_t first_own_scan = 0) : first_own_scan_(first_own_scan) {}

  int session() const { return session_; }
  void begin_session() { ++session_; }
  /// The newest session is part of the map. @param map_scans  of the whole map
  void end_joined(std::size_t map_scans);
  /// The newest session was found nowhere.
  void end_apart(std::size_t scans, SavedMap map);
  void group_apart(const SlamOptions& slam_options, const LocalizerOptions& localizer_options);
  const std::vector<Apart>& apart() const { return apart_; }

  /// One pose a scan of all sessions; nothing for those of sessions apart. @param map  poses of all
  /// scans of the map  @param alone  of the newest session where it is not part of the map
  std::vector<std::optional<Pose2>> poses(const Trajectory& map,
                                          const std::optional<Trajectory>& alone) const;

 private:
  struct Part {
    std::size_t scans;
    bool is_apart;
  };
  std::vector<Part> parts_;
  std::vector<Apart> apart_;
  int session_ = 1;
  std::size_t first_own_scan_;
};

}  // namespace marco::slam
