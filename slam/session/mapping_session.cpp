#include "slam/session/mapping_session.hpp"

#include <algorithm>
#include <utility>

#include "slam/localization/place_gates.hpp"
#include "slam/map/keyframe_grid.hpp"
#include "slam/session/mending.hpp"
#include "slam/session/merge_maps.hpp"

namespace marco::slam {

ResumedPlace::ResumedPlace(const SlamState& map, const MotionOptions& options)
    : motion_(options), map_from_robot_(map.estimate.world_from_robot) {
  motion_.restore(map.motion);
  if (map.motion.before) stopped_ = map.motion.before->utime;
}

std::optional<FoundPlace> ResumedPlace::look(SessionFinder& finder,
                                             const Keyframe& newest,
                                             const MotionInput& now) {
  if (guesses_.empty()) {
    // After a crash of SLAM alone the robot drives on, into what the map does not know yet; after
    // a longer time, or a clock that was set, it may be anywhere: there the map has to know all.
    constexpr double kAwhileS = 30.0;
    const double since_s = stopped_ ? (now.utime - *stopped_).seconds() : -1.0;
    const bool is_recent = since_s >= 0.0 && since_s < kAwhileS;
    const double all = PlaceFinderOptions{}.sure_explained;
    const Pose2 moved = motion_.guess(now, false).before_from_now;
    const Pose2 session_from_then = newest.world_from_robot.inverse();
    guesses_ = {{map_from_robot_ * moved * session_from_then, is_recent,
                 is_recent ? place_gates::kExplained : all},
                {map_from_robot_ * session_from_then, false, all}};
  }
  for (const Guess& guess : guesses_) {
    const Pose2 map_from_robot = guess.map_from_session * newest.world_from_robot;
    if (auto place = finder.look_at(newest, map_from_robot, guess.explained)) {
      is_continued_ = guess.is_continued;
      return place;
    }
  }
  return std::nullopt;
}

MappingSession::MappingSession(const SlamOptions& slam, const LocalizerOptions& localizer)
    : slam_options_(slam), localizer_options_(localizer), slam_(slam) {
  validate(localizer, "localizer");
}

void MappingSession::reset(const Pose2& world_from_robot) {
  SlamState start;
  start.estimate.world_from_robot = world_from_robot;
  check(start);
  mode_ = Mode::mapping;
  to_extend_ = {};
  localizer_.reset();
  findings_.clear();
  mended_.clear();
  history_ = SessionHistory(0);
  map_from(start);
}

void MappingSession::map_from(const SlamState& start) {
  revisions_before_ = revision() + 1;
  session_starts_ = {0};
  slam_ = Slam(slam_options_);
  slam_.set_edits(edits_);
  if (deferred_) slam_.defer_loop_work();
  if (path_every_m_) slam_.keep_short_path(*path_every_m_);
  slam_.restore(start);
}

void MappingSession::set_edits(const MapEdits& edits) {
  edits_ = edits;
  slam_.set_edits(edits);
}

void MappingSession::defer_loop_work() {
  deferred_ = true;
  slam_.defer_loop_work();
}

void MappingSession::keep_short_path(double every_m) {
  path_every_m_ = every_m;
  slam_.keep_short_path(every_m, first_scan());
  if (localizer_) localizer_->keep_no_path();
}

void MappingSession::extend(SavedMap map) {
  auto frozen =
      std::make_unique<FrozenMap>(map.slam.keyframes.keys, localizer_options_, slam_options_);
  reset();
  history_ = SessionHistory(map.slam.path.scans.size());
  mode_ = Mode::extending;
  to_extend_.frozen = std::move(frozen);
  to_extend_.finder.emplace(*to_extend_.frozen, localizer_options_);
  to_extend_.map = std::move(map);
}

void MappingSession::resume(SavedMap map) {
  extend(std::move(map));
  to_extend_.resumed.emplace(to_extend_.map.slam, slam_options_.motion);
}

std::optional<SavedMap> MappingSession::give_up_after(double path_m) {
  if (waiting_map() == nullptr || keys().empty() || keys().back().path_m < path_m) {
    return std::nullopt;
  }
  mode_ = Mode::mapping;
  history_ = SessionHistory(0);
  return std::exchange(to_extend_, {}).map;
}

std::optional<FoundPlace> MappingSession::look(const MotionInput& now) {
  if (to_extend_.resumed) {
    if (auto place = to_extend_.resumed->look(*to_extend_.finder, slam_.keys().back(), now)) {
      return place;
    }
  }
  return to_extend_.finder->look(slam_.keys());
}

Localizer MappingSession::localizer_in(SavedMap map) const {
  return {std::move(map.slam.keyframes.keys), localizer_options_, slam_options_};
}

void MappingSession::localize(Localizer localizer) {
  reset();
  mode_ = Mode::localizing;
  localizer_.emplace(std::move(localizer));
  if (path_every_m_) localizer_->keep_no_path();
}

void MappingSession::start_session() {
  if (localizer_) {
    localizer_->forget_place();
  } else if (slam_.keys().empty()) {
    slam_.forget_motion();
  } else {
    end_session();
    mode_ = Mode::extending;
    to_extend_.joined = false;
    if (!to_extend_.frozen) {
      to_extend_.frozen = std::make_unique<FrozenMap>(to_extend_.map.slam.keyframes.keys,
                                                      localizer_options_, slam_options_);
    }
    to_extend_.finder.emplace(*to_extend_.frozen, localizer_options_);
    map_from({});
  }
  history_.begin_session();
}

void MappingSession::finish_map() {
  slam_.finish();
  // Never revise loop closures that the user edited.
  const bool by_hand = std::any_of(edits_.begin(), edits_.end(), [](const MapEdit& edit) {
    return edit.kind == MapEdit::Kind::add_loop || edit.kind == MapEdit::Kind::forbid_loop;
  });
  if (by_hand) return;
  const MapEdits done = mend(slam_);
  mended_.insert(mended_.end(), done.begin(), done.end());
}

void MappingSession::end_session() {
  finish_map();
  const std::size_t scans = slam_.trajectory().size();
  if (is_alone()) {
    history_.end_apart(scans, saved(""));
  } else {
    to_extend_.map = saved("");
    history_.end_joined(scans);
  }
}

void MappingSession::set_pose(const Pose2& world_from_robot) {
  if (localizer_) {
    localizer_->set_pose(world_from_robot);
  } else {
    reset(world_from_robot);
  }
}

SlamUpdate MappingSession::process(const SlamInput& input) {
  if (localizer_) return localizer_->process(input);
  SlamUpdate update = slam_.process(input);
  if (!is_alone()) return update;
  if (update.became_key) {
    if (const auto place = look(input.motion)) {
      if (slam_.keys().size() == 1 && to_extend_.resumed && to_extend_.resumed->is_continued()) {
        restore(SavedMap(std::move(to_extend_.map)));
        return slam_.process(input);
      }
      findings_.push_back({input.scan.utime, slam_.keys().back().path_m, *place});
      join(*place);
      update.world_from_robot = slam_.trajectory().back().world_from_robot;
      update.covariance = place->covariance;
      update.trajectory_changed = true;
      return update;
    }
  }
  update.status = SlamUpdate::Status::lost;
  return update;
}

void MappingSession::join(const FoundPlace& place) {
  const PoseGraphEdge edge =
      edge_to(*to_extend_.frozen, place, static_cast<int>(slam_.keys().size()) - 1);
  const SlamState session = slam_.state();
  session_starts_ = to_extend_.map.session_starts;
  session_starts_.push_back(static_cast<int64_t>(to_extend_.map.slam.path.scans.size()));
  revisions_before_ += slam_.revision() + 1;
  slam_.restore(to_extend_.map.slam);
  slam_.join(session, edge);
  if (path_every_m_) slam_.keep_short_path(*path_every_m_, first_scan());
  to_extend_ = {};
  to_extend_.joined = true;
}

void MappingSession::finish() {
  if (localizer_) return;
  if (history_.session() == 1 || !is_alone()) {
    finish_map();
  } else {
    end_session();
    // The map is that of the others again.
    const SavedMap others = std::exchange(to_extend_, {}).map;
    map_from(others.slam);
    session_starts_ = others.session_starts;
    mode_ = Mode::mapping;
  }
  history_.group_apart(slam_options_, localizer_options_);
}

const std::vector<Finding>& MappingSession::findings() const {
  return localizer_ ? localizer_->findings() : findings_;
}

const PlaceEstimate* MappingSession::estimate() const {
  if (localizer_) return &localizer_->estimate();
  return to_extend_.finder ? &to_extend_.finder->estimate() : nullptr;
}

ScanVelocity MappingSession::velocity_during(const std::optional<Pose2>& odometry_step,
                                             double duration_s) const {
  if (to_extend_.resumed && slam_.keys().empty()) {
    return to_extend_.resumed->motion().velocity_during(odometry_step, duration_s);
  }
  return localizer_ ? localizer_->velocity_during(odometry_step, duration_s)
                    : slam_.velocity_during(odometry_step, duration_s);
}

std::vector<std::optional<Pose2>> MappingSession::trajectory() const {
  if (localizer_) return localizer_->trajectory();
  const Trajectory now = slam_.trajectory();
  if (!is_alone()) return history_.poses(now, std::nullopt);
  const SlamState& map = to_extend_.map.slam;
  return history_.poses(trajectory_of(map.path.scans, map.keyframes.keys), now);
}

const std::vector<Keyframe>& MappingSession::keys() const {
  return localizer_ ? localizer_->keys() : slam_.keys();
}

Trajectory MappingSession::key_trajectory() const {
  return localizer_ ? trajectory_of(keys()) : slam_.key_trajectory();
}

OccupancyGrid MappingSession::grid() const { return draw_grid(keys(), slam_options_.grid); }

SavedMap MappingSession::saved(const std::string& options) const {
  return {options, session_starts_, slam_.state()};
}

void MappingSession::restore(const SavedMap& map) {
  check(map);
  reset();
  slam_.restore(map.slam);
  session_starts_ = map.session_starts;
  history_ = SessionHistory(first_scan());
  if (path_every_m_) slam_.keep_short_path(*path_every_m_, first_scan());
}

}  // namespace marco::slam
