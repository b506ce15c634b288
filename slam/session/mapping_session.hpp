#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/localization/localizer.hpp"
#include "slam/mapper2d.hpp"
#include "slam/session/session_history.hpp"

namespace marco::slam {

/// Where a robot stands when mapping resumes after a stop: where it stood, or where odometry says
/// that it has gone since. Scans must confirm it. Not thread-safe.
class ResumedPlace {
 public:
  /// @param map  as it was at the stop
  ResumedPlace(const SlamState& map, const MotionOptions& options);

  /// Call for each new keyframe of the session that resumes, from the first one on.
  /// @param now  of its scan
  std::optional<FoundPlace> look(SessionFinder& finder,
                                 const Keyframe& newest,
                                 const MotionInput& now);
  /// The place is where the robot's own motion led since a stop of some seconds: Slam may continue
  /// as if it had never stopped.
  bool is_continued() const { return is_continued_; }
  /// As it was at the stop.
  const MotionModel& motion() const { return motion_; }

 private:
  struct Guess {
    Pose2 map_from_session;
    bool is_continued;
    double explained;  ///< part of a scan that the map has to know
  };

  MotionModel motion_;
  std::optional<Utime> stopped_;
  Pose2 map_from_robot_;
  std::vector<Guess> guesses_;  ///< the likeliest first
  bool is_continued_ = false;
};

/// A mapping session: makes a map, extends a saved one as soon as it has found itself in it, or
/// localizes in one that stays as it is. Not thread-safe.
class MappingSession : public Mapper2d {
 public:
  enum class Mode { mapping, extending, localizing };

  MappingSession(const SlamOptions& slam, const LocalizerOptions& localizer);

  /// Forgets everything and maps from here. @param world_from_robot  where the robot is now
  void reset(const Pose2& world_from_robot = {});
  /// Discards everything, starts a new map, and joins `map` once the robot is localized in it.
  /// @throws std::invalid_argument for a map without points for place recognition.
  void extend(SavedMap map);
  /// The same with an interrupted map: searches first at its robot's last pose, then everywhere.
  /// Until it has joined, `map` is waiting_map(). @throws as extend.
  void resume(SavedMap map);
  /// Extending or resuming, if the robot was not found over `path_m`: the path driven becomes a
  /// separate map. @returns the map in which it was not found; nothing while the search continues
  std::optional<SavedMap> give_up_after(double path_m);
  /// A localizer for `map`; changes nothing. @throws as extend.
  Localizer localizer_in(SavedMap map) const;
  /// Forgets everything and localizes.
  void localize(Localizer localizer);
  /// A new recording session, perhaps of another place: it is mapped separately until it is found
  /// in the map so far, which it then joins. A session not found before the next one starts, or
  /// before finish(), is set apart(). Localizing: the search starts again.
  void start_session();

  SlamUpdate process(const SlamInput& input);
  /// See Slam. Persists across reset and extend.
  void set_edits(const MapEdits& edits);
  /// See Slam. Persists across reset, extend and localize.
  void defer_loop_work();
  /// See Slam; of this session. A localizer then keeps no path. Persists across reset, extend and
  /// localize.
  void keep_short_path(double every_m);
  std::optional<LoopWork> take_loop_work() { return slam_.take_loop_work(); }
  bool accept(const LoopWork& work) { return slam_.accept(work); }
  /// The robot is here: tracks from this pose when localizing, else starts a new map from it.
  void set_pose(const Pose2& world_from_robot);
  /// See Slam::finish, mend(), and start_session(); nothing when localizing.
  void finish();

  /// What finish() did to maps that contradicted themselves; see mend(). Nothing where edits add or
  /// forbid loops.
  const MapEdits& mended() const { return mended_; }

  Mode mode() const { return mode_; }
  /// It looks for itself in a map that it was to resume; nullptr when it does not.
  const SavedMap* waiting_map() const {
    return is_alone() && to_extend_.resumed ? &to_extend_.map : nullptr;
  }
  /// extending: it has been found in the map that it extends.
  bool joined() const { return to_extend_.joined; }
  const Slam& slam() const { return slam_; }
  /// nullptr unless localizing
  const Localizer* localizer() const { return localizer_ ? &*localizer_ : nullptr; }
  /// Each time it became sure where in the saved map it is.
  const std::vector<Finding>& findings() const;
  /// extending: the result of the last look for the place
  const PlaceEstimate* estimate() const;
  /// See MotionModel.
  ScanVelocity velocity_during(const std::optional<Pose2>& odometry_step, double duration_s) const;
  using Apart = SessionHistory::Apart;
  const std::vector<Apart>& apart() const { return history_.apart(); }
  /// A pose a scan since the last reset or extend; scans of sessions set apart, and when localizing
  /// those that no place was found for, have none.
  std::vector<std::optional<Pose2>> trajectory() const;
  std::vector<std::optional<Pose2>> scan_poses() const override { return trajectory(); }
  const std::vector<Loop>& loops() const override { return slam_.loops(); }
  /// The keyframes of what is mapped, or localized in.
  const std::vector<Keyframe>& keys() const override;
  Trajectory key_trajectory() const override;
  OccupancyGrid grid() const override;
  int64_t revision() const override { return slam_.revision() + revisions_before_; }

  /// To be saved. @param options  as SavedMap::options
  SavedMap saved(const std::string& options) const;
  /// Continues mapping as if it had never stopped. @throws as Slam::restore.
  void restore(const SavedMap& map);
  /// Index of the first scan of this session in slam().trajectory().
  std::size_t first_scan() const { return static_cast<std::size_t>(session_starts_.back()); }
  const std::vector<int64_t>& session_starts() const { return session_starts_; }

 private:
  /// What is extended, until the session has joined it.
  struct MapToExtend {
    std::unique_ptr<FrozenMap> frozen;
    std::optional<SessionFinder> finder;
    std::optional<ResumedPlace> resumed;
    SavedMap map;
    bool joined = false;
  };

  std::optional<FoundPlace> look(const MotionInput& now);
  void join(const FoundPlace& place);
  /// Whether the scans are not, or not yet, part of the map that they are to extend.
  bool is_alone() const { return mode_ == Mode::extending && !to_extend_.joined; }
  void map_from(const SlamState& start);
  void finish_map();
  /// The session is part of the map, or set apart.
  void end_session();

  SlamOptions slam_options_;
  LocalizerOptions localizer_options_;
  Mode mode_ = Mode::mapping;
  Slam slam_;
  std::vector<int64_t> session_starts_ = {0};
  int64_t revisions_before_ = 0;
  std::vector<Finding> findings_;
  MapToExtend to_extend_;
  SessionHistory history_;
  std::optional<Localizer> localizer_;
  MapEdits edits_, mended_;
  bool deferred_ = false;
  std::optional<double> path_every_m_;
};

}  // namespace marco::slam
