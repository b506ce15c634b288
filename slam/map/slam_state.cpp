#include "slam/map/slam_state.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "slam/slam.hpp"

namespace marco::slam {
namespace {

// How far a session is taken to have driven since a loop was last closed: it was just found.
constexpr double kSinceFoundM = 1.0;

// Far beyond any building, and far from where sums of squares lose centimetres.
constexpr double kFarthestM = 1e6;
constexpr double kFarthestPathM = 1e9;

bool is_near(const Pose2& pose) {
  return std::abs(pose.x_m) <= kFarthestM && std::abs(pose.y_m) <= kFarthestM;
}

bool is_index(int index, std::size_t count) {
  return index >= 0 && static_cast<std::size_t>(index) < count;
}

}  // namespace

Trajectory trajectory_of(const std::vector<Keyframe>& keys) {
  Trajectory trajectory;
  trajectory.reserve(keys.size());
  for (const Keyframe& key : keys) trajectory.push_back({key.utime, key.world_from_robot});
  return trajectory;
}

Trajectory trajectory_of(const std::vector<ScanPose>& scans, const std::vector<Keyframe>& keys) {
  Trajectory trajectory;
  trajectory.reserve(scans.size());
  for (const ScanPose& scan : scans) {
    const Pose2 world_from_key =
        scan.key < 0 ? Pose2{} : keys[static_cast<std::size_t>(scan.key)].world_from_robot;
    trajectory.push_back({scan.utime, world_from_key * scan.key_from_robot});
  }
  return trajectory;
}

void check(const SlamState& state) {
  for (const Keyframe& key : state.keys) {
    require(key.points_in_robot.points.cols() == key.points_in_robot.normals.cols(),
            "a keyframe has not one normal a point");
    const Points2& points = key.points_in_robot.points;
    require(is_near(key.world_from_robot) &&
                (points.size() == 0 || points.cwiseAbs().maxCoeff() <= kFarthestM) &&
                key.sensor_in_robot.cwiseAbs().maxCoeff() <= kFarthestM &&
                std::abs(key.path_m) <= kFarthestPathM,
            "a keyframe lies farther away than 1000 km");
  }
  std::size_t loop_edges = 0;
  for (const PoseGraphEdge& edge : state.edges) {
    require(is_index(edge.from, state.keys.size()) && is_index(edge.to, state.keys.size()) &&
                edge.from != edge.to,
            "an edge of the graph ends at no keyframe");
    require(is_near(edge.from_from_to), "an edge of the graph is longer than 1000 km");
    loop_edges += edge.is_loop ? 1 : 0;
  }
  require(state.loops.size() == loop_edges, "loops and loop edges are not as many");
  for (const Loop& loop : state.loops) {
    require(is_index(loop.from, state.keys.size()) && is_index(loop.to, state.keys.size()),
            "a loop ends at no keyframe");
    require(is_near(loop.from_from_to) && is_near(loop.believed), "a loop is longer than 1000 km");
  }
  constexpr int32_t kMostMerged = 100'000'000;  // 30000 km of path
  require(state.merged_keys >= 0 && state.merged_keys <= kMostMerged,
          "no such number of keyframes that became one with others");
  require(state.trail.size() >= state.keys.size() &&
              state.trail.size() - state.keys.size() <= static_cast<std::size_t>(state.merged_keys),
          "there are more keyframes than ever were");
  for (const std::vector<ScanPose>* scans : {&state.scans, &state.trail}) {
    for (const ScanPose& scan : *scans) {
      require(scan.key == -1 || is_index(scan.key, state.keys.size()),
              "a scan's pose hangs on no keyframe");
      require(is_near(scan.key_from_robot), "a scan lies farther away than 1000 km");
    }
  }
  require(std::all_of(state.trail.begin(), state.trail.end(),
                      [](const ScanPose& pose) { return pose.key >= 0; }),
          "a keyframe's pose hangs on no keyframe");
  const auto count = static_cast<int32_t>(state.keys.size());
  require(state.looked_at >= 0 && state.looked_at <= count && state.thin_until <= count &&
              state.kept_keys >= 0 && state.kept_keys <= count,
          "more keyframes were looked at than there are");
  require(state.unmatched >= 0 && state.unmatched < 1'000'000, "no such number of unmatched scans");
  require(is_near(state.world_from_robot), "the robot is farther away than 1000 km");
}

SlamState Slam::state() const {
  SlamState state;
  state.keys = keys_;
  state.edges = graph_.edges();
  state.loops = loops_;
  state.scans = scans_;
  state.trail = trail_;
  state.motion = motion_.state();
  if (standing_) state.standing = standing_->state();
  state.world_from_robot = world_from_robot_;
  state.covariance = covariance_;
  state.last_search_path_m = last_search_path_m_;
  state.closed_path_m = closed_path_m_;
  state.closings_m = closings_m_;
  state.revision = revision_;
  state.looked_at = looked_at_;
  state.thin_until = thin_until_;
  state.kept_keys = kept_keys_;
  state.merged_keys = merged_keys_;
  state.leaps_since = leaps_since_;
  state.unmatched = unmatched_;
  if (local_map_) state.local_map_centre_m = local_map_->levels().front().centre_m();
  return state;
}

void Slam::restore(const SlamState& state) {
  check(state);
  keys_ = state.keys;
  loops_ = state.loops;
  scans_ = state.scans;
  trail_ = state.trail;
  work_.reset();
  work_is_out_ = false;
  graph_ = PoseGraph(options_.graph);
  for (const Keyframe& key : keys_) graph_.add_node(key.world_from_robot);
  for (const PoseGraphEdge& edge : state.edges) graph_.add_edge(edge);
  motion_.restore(state.motion);
  standing_.reset();
  if (state.standing) standing_.emplace(*state.standing);
  covariance_ = state.covariance;
  last_search_path_m_ = state.last_search_path_m;
  closed_path_m_ = state.closed_path_m;
  closings_m_ = state.closings_m;
  revision_ = state.revision;
  refined_ = {};
  merged_keys_ = state.merged_keys;
  local_map_.reset();
  likelihood_.reset();
  if (!keys_.empty()) rebuild_local_map(state.local_map_centre_m);
  looked_at_ = state.looked_at;
  thin_until_ = state.thin_until;
  kept_keys_ = state.kept_keys;
  leaps_since_ = state.leaps_since;
  unmatched_ = state.unmatched;
  world_from_robot_ = state.world_from_robot;
}

void Slam::join(const SlamState& session, const PoseGraphEdge& tie) {
  check(session);
  require(is_index(tie.from, keys_.size()) && is_index(tie.to, session.keys.size()),
          "join: the tie ends at no keyframe");
  const int first_key = static_cast<int>(keys_.size());
  const Keyframe& tied = session.keys[static_cast<std::size_t>(tie.to)];
  const Pose2 world_from_session = keys_[static_cast<std::size_t>(tie.from)].world_from_robot *
                                   tie.from_from_to * tied.world_from_robot.inverse();
  // A session starts far from the end of the one before: places of both are worth looking at.
  const double path_m = keys_.back().path_m + options_.loops.min_path_m;
  for (Keyframe key : session.keys) {
    key.world_from_robot = world_from_session * key.world_from_robot;
    key.path_m += path_m;
    graph_.add_node(key.world_from_robot);
    keys_.push_back(std::move(key));
  }
  for (PoseGraphEdge edge : session.edges) {
    edge.from += first_key;
    edge.to += first_key;
    graph_.add_edge(edge);
  }
  for (Loop loop : session.loops) {
    loop.from += first_key;
    loop.to += first_key;
    loops_.push_back(loop);
  }
  PoseGraphEdge moved_tie = tie;
  moved_tie.to += first_key;
  moved_tie.is_loop = false;
  graph_.add_edge(moved_tie);
  for (ScanPose scan : session.scans) {
    if (scan.key < 0) {
      scan.key_from_robot = world_from_session * scan.key_from_robot;
    } else {
      scan.key += first_key;
    }
    scans_.push_back(scan);
  }
  for (ScanPose scan : session.trail) {
    scan.key += first_key;
    trail_.push_back(scan);
  }
  merged_keys_ += session.merged_keys;
  looked_at_ = thin_until_ = kept_keys_ = static_cast<int>(keys_.size());
  world_from_robot_ = world_from_session * session.world_from_robot;
  covariance_ = session.covariance;
  motion_.restore(session.motion);
  standing_.reset();
  leaps_since_ = session.leaps_since;
  unmatched_ = session.unmatched;
  // Nothing lies between the sessions: what is looked at around a place ends there.
  std::vector<Keyframe> nearby(keys_.begin(), keys_.begin() + first_key);
  Keyframe nothing;
  nothing.points_in_robot = {Points2(2, 0), Points2(2, 0)};
  nothing.path_m = keys_.back().path_m;
  nearby.resize(nearby.size() + static_cast<std::size_t>(options_.loops.around), nothing);
  for (int key = first_key; key < static_cast<int>(keys_.size()); ++key) {
    find_loops_across(key, first_key, nearby);
  }
  last_search_path_m_ = closed_path_m_ = keys_.back().path_m;
  ++revision_;
  rebuild_local_map();
}

void Slam::find_loops_across(int key, int first_key, std::vector<Keyframe>& nearby) {
  // Of the new session as many keyframes as are matched together.
  const int first_nearby = first_key + options_.loops.around;
  if (static_cast<int>(nearby.size()) > first_nearby + options_.loops.around) {
    nearby.erase(nearby.begin() + first_nearby);
  }
  const Keyframe& newest = keys_[static_cast<std::size_t>(key)];
  nearby.push_back(newest);
  const bool is_last = static_cast<std::size_t>(key) + 1 == keys_.size();
  if (newest.path_m - last_search_path_m_ < options_.loops.attempt_every_m && !is_last) return;
  last_search_path_m_ = newest.path_m;
  bool found_any = false;
  for (Loop loop : loop_closer_.find(nearby, newest.path_m - kSinceFoundM)) {
    if (loop.from >= first_key) continue;
    loop.to = key;
    loops_.push_back(loop);
    graph_.add_edge({loop.from, loop.to, loop.from_from_to, loop.information, true});
    found_any = true;
  }
  if (!found_any) return;
  graph_.optimize();
  move_keys(graph_.poses());
  for (int i = 0; i < static_cast<int>(nearby.size()); ++i) {
    const int newest_nearby = static_cast<int>(nearby.size()) - 1;
    const int at = i < first_key ? i : key - (newest_nearby - i);
    if (i >= first_key && i < first_nearby) continue;
    nearby[static_cast<std::size_t>(i)].world_from_robot =
        keys_[static_cast<std::size_t>(at)].world_from_robot;
  }
}

}  // namespace marco::slam
