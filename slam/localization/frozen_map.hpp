#pragma once

#include <optional>
#include <vector>

#include "slam/localization/place_finder.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

struct LocalizerOptions {
  PlaceMapOptions map;
  PlaceFinderOptions finder;
  double local_radius_m = 10.0;    ///< the map about the robot is made of the keyframes within this
  int local_keyframes = 60;        ///< at most, the nearest ones
  double renew_after_m = 1.5;      ///< of driving, the local map is rebuilt
  double good_overlap = 0.60;      ///< a place found is taken when the fine match reaches it
  double poor_overlap = 0.35;      ///< a match below it is not used
  double max_contradicted = 0.15;  ///< of a scan's beams, that may end in known free space
  double lost_after_m = 1.0;       ///< so far with scans that contradict the map, or ...
  double lost_after_s = 5.0;       ///< ... so long: carried away, search again
  double unknown_for_m = 30.0;     ///< so far where the map is silent its own path is believed
  double map_sigma_m = 0.02;       ///< the map's own error, in every covariance
  double map_sigma_deg = 0.2;

  template <class Visitor>
  void visit(Visitor& v) {
    v("finder", finder);
    v.advanced("good_overlap", good_overlap, Limits{0.0, 1.0},
               "A place is accepted when the fine match reaches this overlap.");
    v.advanced("poor_overlap", poor_overlap, Limits{0.0, 1.0},
               "Matches that overlap less are rejected. Less where much has changed since the map "
               "was made.");
    v.advanced(
        "max_contradicted", max_contradicted, Limits{0.0, 1.0},
        "Fraction of a scan's beams that may end where the map is free. More among many people.");
    v("lost_after_m", lost_after_m, kPositive,
      "Relocalization starts after this distance with scans that contradict the map. More among "
      "crowds.");
    v.advanced("lost_after_s", lost_after_s, kPositive,
               "Relocalization starts after this time with scans that contradict the map.");
    v.advanced(
        "unknown_for_m", unknown_for_m, kPositive,
        "Beyond the map, dead reckoning is trusted over this distance. Less for poor odometry.");
  }
};

Beams beams_of(const OrientedPoints& points_in_robot, const Eigen::Vector2d& sensor_in_robot);

/// A saved map that does not change, and fine matches against it about a place.
class FrozenMap {
 public:
  /// @throws std::invalid_argument as PlaceMap.
  FrozenMap(std::vector<Keyframe> keys, const LocalizerOptions& options, const SlamOptions& slam);

  const PlaceMap& places() const { return places_; }
  const std::vector<Keyframe>& keys() const { return keys_; }

  /// The fine match of a scan about a guess. Rebuilds the local map when the guess has moved far.
  SurfelMatch match(const OrientedPoints& points_in_robot,
                    const Pose2& map_from_robot_guess,
                    const PosePrior* prior);
  /// The same after an exhaustive search about the guess; nothing where the search finds nothing.
  std::optional<SurfelMatch> match_widely(const OrientedPoints& points_in_robot,
                                          const Pose2& map_from_robot_guess);
  /// With the map's own error. @param information  of a match
  Eigen::Matrix3d covariance_of(const Eigen::Matrix3d& information) const;
  int nearest_key(const Pose2& map_from_robot) const;

 private:
  void rebuild_local_map(const Eigen::Vector2d& centre_m);

  std::vector<Keyframe> keys_;
  LocalizerOptions options_;
  SurfelMatcher matcher_;
  CorrelativeMatcher coarse_;
  PlaceMap places_;
  std::optional<SurfelPyramid> local_;
  Eigen::Vector2d local_centre_m_ = Eigen::Vector2d::Zero();
};

}  // namespace marco::slam
