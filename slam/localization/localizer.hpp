#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/localization/session_finder.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

/// When a robot that is tracked in a map counts as lost.
struct TrackingLimits {
  double contradicted_m;  ///< driven with scans that contradict the map, or ...
  double contradicted_s;  ///< ... time with such
  double unknown_m;       ///< driven where the map is silent
};

/// Whether tracking in a map can still be trusted. Not thread-safe.
class TrackingState {
 public:
  /// What a scan says of the pose that is believed.
  enum class Verdict { confirmed, says_nothing, contradicted };

  void begin(std::optional<Utime> confirmed_at);
  /// @param moves_fit  scans fit each other: they were not taken anywhere else
  /// @param moved_m  since the scan before. @returns whether the robot is lost.
  bool is_lost_after(
      Utime utime, Verdict verdict, bool moves_fit, double moved_m, const TrackingLimits& limits);
  int times_lost() const { return times_lost_; }

 private:
  std::optional<Utime> last_match_;
  double contradicted_m_ = 0.0;   ///< driven since the map last confirmed, or said nothing
  double unknown_m_ = 0.0;        ///< driven since it last confirmed
  bool tracking_broken_ = false;  ///< since it last confirmed, scans did not fit each other
  int times_lost_ = 0;
};

/// A robot's motion by its scans alone: a small SLAM of its own last metres, without loops. Not
/// thread-safe.
class ScanOdometry {
 public:
  explicit ScanOdometry(const SlamOptions& options);

  /// How the robot moved since the scan before.
  struct Move {
    Pose2 before_from_now;
    Eigen::Matrix3d covariance;
    bool by_scans = false;  ///< scans fit each other; else `guess`
  };
  /// @param guess  dead reckoning
  Move move(const SlamInput& input, const MotionGuess& guess);

  /// The SLAM itself, while a place is looked for.
  Slam& session() { return session_; }
  const Slam& session() const { return session_; }
  /// From here on only the motion is asked for. @param session_from_robot  at the last scan
  void begin(const Pose2& session_from_robot);
  void reset();

 private:
  SlamOptions options_;
  Slam session_;
  Pose2 session_from_robot_;
};

/// The path of a robot that is localized in pieces: parts driven before a place was found have
/// their poses from the path that led there.
class LocalizedPath {
 public:
  /// From here on nothing is kept.
  void keep_nothing();
  /// Of the session that looks for its place.
  void add_unplaced(const Pose2& session_from_robot);
  void add(const Pose2& map_from_robot);
  void place_session(const Pose2& map_from_session) {
    map_from_sessions_.back() = map_from_session;
  }
  void begin_session() { map_from_sessions_.emplace_back(); }
  /// One pose a scan; nothing where the place was never found.
  std::vector<std::optional<Pose2>> poses() const;

 private:
  struct ScanPose {
    int session = -1;  ///< -1 = the pose is the map's
    Pose2 frame_from_robot;
  };
  std::vector<std::optional<Pose2>> map_from_sessions_ = {std::nullopt};
  std::vector<ScanPose> scans_;
  bool is_kept_ = true;
};

/// Localization in a saved map, which stays as it is. Searches everywhere until it is sure, then
/// tracks, and relocalizes when the scans contradict the map. Where the map knows nothing (a room
/// whose door was closed), the robot is tracked by its scans alone.
///
/// While it searches, poses are given in the session's own frame, with status `lost`. Not
/// thread-safe.
class Localizer {
 public:
  /// @throws std::invalid_argument for a map without points, or options outside their limits.
  Localizer(std::vector<Keyframe> map,
            const LocalizerOptions& options = {},
            const SlamOptions& slam = {});

  SlamUpdate process(const SlamInput& input);
  /// The robot is here: tracks from this pose.
  void set_pose(const Pose2& map_from_robot);
  /// As if just switched on.
  void forget_place();

  bool is_localized() const { return tracking_; }
  /// Of the map.
  const std::vector<Keyframe>& keys() const { return map_->keys(); }
  /// Of the last look.
  const PlaceEstimate& estimate() const { return finder_.estimate(); }
  int times_lost() const { return tracking_state_.times_lost(); }
  /// Each time it became sure.
  const std::vector<Finding>& findings() const { return findings_; }
  /// See MotionModel.
  ScanVelocity velocity_during(const std::optional<Pose2>& odometry_step, double duration_s) const {
    return tracking_ ? motion_.velocity_during(odometry_step, duration_s)
                     : odometry_.session().velocity_during(odometry_step, duration_s);
  }

  /// One pose a scan, in the map's frame; scans before a place was found have it from the path that
  /// led there. Nothing where the place was never found.
  std::vector<std::optional<Pose2>> trajectory() const { return path_.poses(); }
  /// From here on trajectory() ends.
  void keep_no_path() { path_.keep_nothing(); }

 private:
  /// A scan as the map is asked about it.
  struct View {
    OrientedPoints points;
    Beams beams;
  };

  SlamUpdate search(const SlamInput& input);
  SlamUpdate track(const SlamInput& input);
  void begin_tracking(const PoseWithCovariance& estimate);
  /// By the map, where it knows something.
  void correct(const View& view, const PosePrior& prior, bool by_scans, SlamUpdate& update);
  bool contradicts(const Beams& beams, const Pose2& map_from_robot) const;
  SurfelMatch match(const View& view, const PosePrior& prior, bool by_scans);
  TrackingState::Verdict judge(const Beams& beams, const SlamUpdate& update) const;

  LocalizerOptions options_;
  MatchGateOptions gates_;
  NormalOptions normals_;
  RangeNoise noise_;
  std::unique_ptr<FrozenMap> map_;  ///< stays where it is when the localizer moves
  SessionFinder finder_;
  ScanOdometry odometry_;
  MotionModel motion_;
  PoseWithCovariance estimate_;  ///< of the map, while tracking
  bool tracking_ = false;
  TrackingState tracking_state_;
  LocalizedPath path_;
  std::vector<Finding> findings_;
};

}  // namespace marco::slam
