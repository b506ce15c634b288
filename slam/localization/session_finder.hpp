#pragma once

#include <optional>
#include <vector>

#include "slam/localization/frozen_map.hpp"

namespace marco::slam {

/// A pose in a saved map, searched anywhere in it.
struct FoundPlace {
  Pose2 map_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double overlap = 0.0;
  int nearest_key = 0;  ///< of the map
};

/// Relocalization: finds a session in a saved map, from its keyframes.
class SessionFinder {
 public:
  /// @param map  outlives the finder
  SessionFinder(FrozenMap& map, const LocalizerOptions& options);

  /// Call after each new keyframe of the session. Where nothing was found over a long way it
  /// searches seldom. @returns the newest keyframe's place, once.
  std::optional<FoundPlace> look(const std::vector<Keyframe>& session);
  /// Whether the newest keyframe was taken here, by its beams and a fine match; searches nowhere
  /// else.
  /// @param explained  part of its beams that must end on walls of the map
  std::optional<FoundPlace> look_at(const Keyframe& newest,
                                    const Pose2& map_from_robot_guess,
                                    double explained);
  /// The result of the last look.
  const PlaceEstimate& estimate() const { return estimate_; }
  void restart();

 private:
  std::optional<FoundPlace> refined(const Keyframe& newest, const Pose2& guess, double overlap);

  FrozenMap* map_;
  LocalizerOptions options_;
  PlaceFinder finder_;
  PlaceEstimate estimate_;
  std::optional<double> began_m_;  ///< path when it looked first
  double looked_m_ = 0.0;          ///< and last
};

/// When a place was found.
struct Finding {
  Utime utime;          ///< of the scan that made it sure
  double path_m = 0.0;  ///< driven since it began to look
  FoundPlace place;
};

}  // namespace marco::slam
