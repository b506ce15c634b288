#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/localization/place_finder.hpp"
#include "slam/localization/saved_map.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

struct LocalizerOptions {
  PlaceMapOptions map;
  PlaceFinderOptions finder;
  double local_radius_m = 10.0;    ///< the map about the robot is made of the keyframes within this
  int local_keyframes = 60;        ///< the nearest so many
  double renew_after_m = 1.5;      ///< of driving
  double good_overlap = 0.60;      ///< a place found is taken when the fine match reaches it
  double poor_overlap = 0.35;      ///< a match below it is not used
  double max_contradicted = 0.15;  ///< of a scan's beams, that may end in known free space
  double lost_after_m = 1.0;       ///< so far with scans that contradict the map, or ...
  double lost_after_s = 5.0;       ///< ... so long: carried away, look anew
  double unknown_for_m = 30.0;     ///< so far where the map is silent its own path is believed
  double map_sigma_m = 0.02;       ///< the map's own error, in every covariance
  double map_sigma_deg = 0.2;

  template <class Visitor>
  void visit(Visitor& v) {
    v("map", map);
    v("finder", finder);
    v("local_radius_m", local_radius_m, kPositive);
    v("local_keyframes", local_keyframes, Limits{1, 10000});
    v("renew_after_m", renew_after_m, kNotNegative);
    v("good_overlap", good_overlap, Limits{0.0, 1.0});
    v("poor_overlap", poor_overlap, Limits{0.0, 1.0});
    v("max_contradicted", max_contradicted, Limits{0.0, 1.0});
    v("lost_after_m", lost_after_m, kPositive);
    v("lost_after_s", lost_after_s, kPositive);
    v("unknown_for_m", unknown_for_m, kPositive);
    v("map_sigma_m", map_sigma_m, kPositive);
    v("map_sigma_deg", map_sigma_deg, kPositive);
  }
};

/// A pose in a saved map, searched anywhere in it.
struct FoundPlace {
  Pose2 map_from_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double overlap = 0.0;
  int nearest_key = 0;  ///< of the map
};

/// A saved map that does not change, and fine matches against it about a place.
class FrozenMap {
 public:
  /// @throws std::invalid_argument as PlaceMap.
  FrozenMap(std::vector<Keyframe> keys, const LocalizerOptions& options, const SlamOptions& slam);

  const PlaceMap& places() const { return places_; }
  const std::vector<Keyframe>& keys() const { return keys_; }

  /// The fine match of a scan about a guess. Makes the local map anew when the guess has moved on.
  SurfelMatch match(const OrientedPoints& points_in_robot,
                    const Pose2& map_from_robot_guess,
                    const PosePrior* prior);
  Eigen::Matrix3d covariance_of(const Eigen::Matrix3d& information) const;
  int nearest_key(const Pose2& map_from_robot) const;

 private:
  void renew(const Eigen::Vector2d& centre_m);

  std::vector<Keyframe> keys_;
  LocalizerOptions options_;
  SurfelMatcher matcher_;
  PlaceMap places_;
  std::optional<SurfelPyramid> local_;
  Eigen::Vector2d local_centre_m_ = Eigen::Vector2d::Zero();
};

/// A session that has not yet been found in a map: looks at each of its keyframes.
class SessionFinder {
 public:
  /// @param map  outlives the finder
  SessionFinder(FrozenMap& map, const LocalizerOptions& options);

  /// Call after each new keyframe of the session. Where nothing was found over a long way it looks
  /// seldom. @returns the newest keyframe's place, once.
  std::optional<FoundPlace> look(const std::vector<Keyframe>& session);
  /// What the last look said.
  const PlaceEstimate& estimate() const { return estimate_; }
  void restart();

 private:
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

/// Where a robot is in a map that somebody saved. Looks anywhere until it is sure, tracks from then
/// on, and looks again when the scans contradict the map. The map stays as it is: where it knows
/// nothing (a room whose door was closed), the robot goes on by a map of its own last metres.
///
/// While it looks, poses are given in the session's own frame, with status `lost`. Not thread-safe.
class Localizer {
 public:
  /// @throws std::invalid_argument for a map without points, or options outside their limits.
  Localizer(std::vector<Keyframe> map,
            const LocalizerOptions& options = {},
            const SlamOptions& slam = {});

  SlamUpdate process(const SlamInput& input);
  /// The robot is here: tracks from this pose.
  void set_pose(const Pose2& map_from_robot);
  /// As if switched on anew.
  void forget_place();

  bool is_localized() const { return tracking_; }
  /// Of the map.
  const std::vector<Keyframe>& keys() const { return map_->keys(); }
  /// Of the last look.
  const PlaceEstimate& estimate() const { return finder_.estimate(); }
  /// Each time it became sure.
  const std::vector<Finding>& findings() const { return findings_; }
  int times_lost() const { return times_lost_; }
  Velocity2 velocity() const { return tracking_ ? motion_.velocity() : session_.velocity(); }

  /// One pose a scan, in the map's frame; scans before a place was found have it from the path that
  /// led there. Nothing where the place was never found.
  std::vector<std::optional<Pose2>> trajectory() const;
  /// From here on trajectory() ends.
  void keep_no_path();

 private:
  struct ScanPose {
    int session = -1;  ///< -1 = the pose is the map's
    Pose2 frame_from_robot;
  };
  /// How the robot moved since the scan before.
  struct Move {
    Pose2 before_from_now;
    Eigen::Matrix3d covariance;
    bool seen = false;  ///< by scans that fit each other, not by odometry alone
  };
  enum class Verdict { confirmed, says_nothing, contradicted };

  SlamUpdate look(const SlamInput& input);
  SlamUpdate track(const SlamInput& input);
  /// From here on the session only says how the robot moves.
  void begin_tracking(const Pose2& map_from_robot, const Eigen::Matrix3d& covariance);
  Move move_to(const SlamInput& input);
  PosePrior prior_of(const Move& move, Eigen::Matrix3d& covariance) const;
  /// By the map, where it knows something.
  void correct(const OrientedPoints& points,
               const Beams& beams,
               const PosePrior& prior,
               bool seen,
               SlamUpdate& update);
  bool contradicts(const Beams& beams, const Pose2& map_from_robot) const;
  SurfelMatch match(const OrientedPoints& points,
                    const Beams& beams,
                    const PosePrior& prior,
                    bool seen);
  Verdict judge(const Beams& beams, const SlamUpdate& update) const;
  void note_confirmed();
  void note_whether_lost(Utime utime, Verdict verdict, double moved_m);

  LocalizerOptions options_;
  SlamOptions slam_options_;
  std::unique_ptr<FrozenMap> map_;  ///< stays where it is when the localizer moves
  CorrelativeMatcher coarse_;
  SessionFinder finder_;
  Slam session_;
  MotionModel motion_;
  bool tracking_ = false;
  Pose2 map_from_robot_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  std::optional<Utime> last_match_;
  double contradicted_m_ = 0.0;  ///< driven since the map last said yes, or nothing
  double unknown_m_ = 0.0;       ///< driven since it last said yes
  bool tracking_broken_ = false;            ///< since it last said yes, scans did not fit each other
  Pose2 session_from_robot_;
  int times_lost_ = 0;
  std::vector<Finding> findings_;
  std::vector<std::optional<Pose2>> map_from_sessions_;
  std::vector<ScanPose> scans_;
  bool path_is_kept_ = true;
};

}  // namespace marco::slam
