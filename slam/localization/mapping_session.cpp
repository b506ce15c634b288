#include "slam/localization/mapping_session.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {

MappingSession::MappingSession(const SlamOptions& slam, const LocalizerOptions& localizer)
    : slam_options_(slam), localizer_options_(localizer), slam_(slam) {
  validate(localizer, "localizer");
}

void MappingSession::reset(const Pose2& world_from_robot) {
  SlamState start;
  start.estimate.world_from_robot = world_from_robot;
  check(start);
  mode_ = Mode::mapping;
  joined_ = false;
  finder_.reset();
  frozen_.reset();
  localizer_.reset();
  base_ = {};
  findings_.clear();
  parts_.clear();
  apart_.clear();
  session_ = 1;
  first_own_scan_ = 0;
  map_from(start);
}

void MappingSession::map_from(const SlamState& start) {
  revisions_before_ = revision() + 1;
  session_starts_ = {0};
  slam_ = Slam(slam_options_);
  if (deferred_) slam_.defer_loop_work();
  if (path_every_m_) slam_.keep_short_path(*path_every_m_);
  slam_.restore(start);
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
  auto frozen = std::make_unique<FrozenMap>(map.slam.keyframes.keys, localizer_options_, slam_options_);
  reset();
  first_own_scan_ = map.slam.path.scans.size();
  mode_ = Mode::extending;
  frozen_ = std::move(frozen);
  finder_.emplace(*frozen_, localizer_options_);
  base_ = std::move(map);
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
    joined_ = false;
    if (!frozen_) {
      frozen_ = std::make_unique<FrozenMap>(base_.slam.keyframes.keys, localizer_options_, slam_options_);
    }
    finder_.emplace(*frozen_, localizer_options_);
    map_from({});
  }
  ++session_;
}

void MappingSession::end_session() {
  slam_.finish();
  std::size_t scans = slam_.trajectory().size();
  const bool is_apart = is_alone();
  if (is_apart) {
    if (!slam_.keys().empty()) apart_.push_back({{session_}, saved("")});
  } else {
    base_ = saved("");
    scans -= first_own_scan_;
    for (const Part& part : parts_) scans -= part.is_apart ? 0 : part.scans;
  }
  parts_.push_back({scans, is_apart});
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
  if (mode_ != Mode::extending || joined_) return update;
  if (update.became_key) {
    if (const auto place = finder_->look(slam_.keys())) {
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

PoseGraphEdge tie_to(const FrozenMap& map, const FoundPlace& place, int newest_key) {
  PoseGraphEdge tie;
  tie.from = place.nearest_key;
  tie.to = newest_key;
  tie.from_from_to =
      between(map.keys()[static_cast<std::size_t>(place.nearest_key)].world_from_robot,
              place.map_from_robot);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0, 0, -place.map_from_robot.theta_rad}.rotation();
  tie.information = (turn * place.covariance * turn.transpose()).inverse();
  return tie;
}

void MappingSession::join(const FoundPlace& place) {
  const PoseGraphEdge tie = tie_to(*frozen_, place, static_cast<int>(slam_.keys().size()) - 1);
  const SlamState session = slam_.state();
  session_starts_ = base_.session_starts;
  session_starts_.push_back(static_cast<int64_t>(base_.slam.path.scans.size()));
  revisions_before_ += slam_.revision() + 1;
  slam_.restore(base_.slam);
  slam_.join(session, tie);
  if (path_every_m_) slam_.keep_short_path(*path_every_m_, first_scan());
  joined_ = true;
  finder_.reset();
  frozen_.reset();
  base_ = {};
}

void MappingSession::finish() {
  if (localizer_) return;
  if (session_ == 1 || !is_alone()) {
    slam_.finish();
  } else {
    end_session();
    // The map is that of the others again.
    const SavedMap others = std::exchange(base_, {});
    map_from(others.slam);
    session_starts_ = others.session_starts;
    mode_ = Mode::mapping;
    finder_.reset();
    frozen_.reset();
  }
  group_apart();
}

void MappingSession::group_apart() {
  std::vector<Apart> groups;
  for (std::vector<Apart> left = std::move(apart_); !left.empty();) {
    std::vector<SavedMap> maps;
    for (const Apart& one : left) maps.push_back(one.map);
    std::vector<std::size_t> not_found;
    Apart group;
    group.map = left.size() == 1
                    ? std::move(maps.front())
                    : merge_maps(std::move(maps), slam_options_, localizer_options_, not_found);
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

const std::vector<Finding>& MappingSession::findings() const {
  return localizer_ ? localizer_->findings() : findings_;
}

const PlaceEstimate* MappingSession::estimate() const {
  if (localizer_) return &localizer_->estimate();
  return finder_ ? &finder_->estimate() : nullptr;
}

Velocity2 MappingSession::velocity() const {
  return localizer_ ? localizer_->velocity() : slam_.velocity();
}

std::vector<std::optional<Pose2>> MappingSession::trajectory() const {
  if (localizer_) return localizer_->trajectory();
  std::vector<std::optional<Pose2>> result;
  const Trajectory map =
      is_alone() ? trajectory_of(base_.slam.path.scans, base_.slam.keyframes.keys) : slam_.trajectory();
  std::size_t next = first_own_scan_;
  for (const Part& part : parts_) {
    for (std::size_t i = 0; i < part.scans; ++i) {
      result.push_back(part.is_apart ? std::nullopt : std::optional(map[next++].world_from_robot));
    }
  }
  const Trajectory now =
      is_alone() ? slam_.trajectory()
                 : Trajectory(map.begin() + static_cast<std::ptrdiff_t>(next), map.end());
  for (const StampedPose2& pose : now) result.emplace_back(pose.world_from_robot);
  return result;
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
  first_own_scan_ = first_scan();
  if (path_every_m_) slam_.keep_short_path(*path_every_m_, first_scan());
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
    slam.join(maps[i].slam, tie_to(frozen, found->place, found->newest_key));
    for (const int64_t start : maps[i].session_starts) {
      merged.session_starts.push_back(scans_before + start);
    }
  }
  slam.finish();
  merged.slam = slam.state();
  return merged;
}

}  // namespace marco::slam
