#include <vector>

#include "common/covariance.hpp"
#include "lcm_tools/base/check.hpp"
#include "slam/back_end/loop_closer.hpp"
#include "slam/slam.hpp"

namespace marco::slam {
namespace {

// How far a session is taken to have driven since a loop was last closed: it was just found.
constexpr double kSinceFoundM = 1.0;

/// Loop closures between a map and a session that was appended to it: each keyframe of the session
/// searches the map, as if it had been driven to after the map's last one. Not thread-safe.
class SessionLoopSearch {
 public:
  /// @param closer  outlives the search
  /// @param keys  of both; those of the session begin at `first_key`
  /// @param searched_path_m  of the last search before
  SessionLoopSearch(const LoopCloser& closer,
                    const std::vector<Keyframe>& keys,
                    int first_key,
                    double searched_path_m);

  /// Call for each keyframe of the session in turn. @returns loops from the map to it.
  std::vector<Loop> search(const std::vector<Keyframe>& keys, int key);
  /// Keyframes have moved. @param key  the last one searched for
  void update_poses(const std::vector<Keyframe>& keys, int key);

 private:
  const LoopCloser* closer_;
  int first_key_;
  double searched_path_m_;
  /// The map's keyframes, a gap of empty ones, and the session's last ones: what is matched
  /// together around a place ends between the sessions.
  std::vector<Keyframe> nearby_;
};

SessionLoopSearch::SessionLoopSearch(const LoopCloser& closer,
                                     const std::vector<Keyframe>& keys,
                                     int first_key,
                                     double searched_path_m)
    : closer_(&closer),
      first_key_(first_key),
      searched_path_m_(searched_path_m),
      nearby_(keys.begin(), keys.begin() + first_key) {
  Keyframe nothing;
  nothing.points_in_robot = {Points2(2, 0), Points2(2, 0)};
  nothing.path_m = keys.back().path_m;
  nearby_.resize(nearby_.size() + static_cast<std::size_t>(closer.options().around), nothing);
}

std::vector<Loop> SessionLoopSearch::search(const std::vector<Keyframe>& keys, int key) {
  const int around = closer_->options().around;
  // Of the session as many keyframes as are matched together.
  const int first_nearby = first_key_ + around;
  if (static_cast<int>(nearby_.size()) > first_nearby + around) {
    nearby_.erase(nearby_.begin() + first_nearby);
  }
  const Keyframe& newest = keys[static_cast<std::size_t>(key)];
  nearby_.push_back(newest);
  const bool is_last = static_cast<std::size_t>(key) + 1 == keys.size();
  if (newest.path_m - searched_path_m_ < closer_->options().attempt_every_m && !is_last) return {};
  searched_path_m_ = newest.path_m;
  std::vector<Loop> loops =
      closer_->find(nearby_, uncertainties_by_path(nearby_), newest.path_m - kSinceFoundM);
  std::erase_if(loops, [this](const Loop& loop) { return loop.from >= first_key_; });
  for (Loop& loop : loops) loop.to = key;
  return loops;
}

void SessionLoopSearch::update_poses(const std::vector<Keyframe>& keys, int key) {
  const int newest_nearby = static_cast<int>(nearby_.size()) - 1;
  for (int i = 0; i <= newest_nearby; ++i) {
    if (i >= first_key_ && i < first_key_ + closer_->options().around) continue;
    const int at = i < first_key_ ? i : key - (newest_nearby - i);
    nearby_[static_cast<std::size_t>(i)].world_from_robot =
        keys[static_cast<std::size_t>(at)].world_from_robot;
  }
}

}  // namespace

void Slam::join(const SlamState& session, const PoseGraphEdge& edge) {
  check(session);
  std::vector<Keyframe>& keys = keyframes_.keys;
  require(is_index(edge.from, keys.size()) && is_index(edge.to, session.keyframes.keys.size()),
          "join: the edge ends at no keyframe");
  const int first_key = static_cast<int>(keys.size());
  const Keyframe& tied = session.keyframes.keys[static_cast<std::size_t>(edge.to)];
  const Pose2 world_from_session = keys[static_cast<std::size_t>(edge.from)].world_from_robot *
                                   edge.from_from_to * tied.world_from_robot.inverse();
  // A session starts far from the end of the one before: places of both are worth comparing.
  const double path_m = keys.back().path_m + options_.loops.min_path_m;
  for (Keyframe key : session.keyframes.keys) {
    key.world_from_robot = world_from_session * key.world_from_robot;
    key.path_m += path_m;
    keys.push_back(std::move(key));
  }
  keyframes_.merged += session.keyframes.merged;
  back_end_.append(session.back_end, first_key);
  back_end_.add_edge({edge.from, edge.to + first_key, edge.from_from_to, edge.information, false});
  path_.append(session.path, first_key, world_from_session);
  culling_.skip_to(static_cast<int>(keys.size()));
  estimate_ = {world_from_session * session.estimate.world_from_robot,
               rotated(session.estimate.covariance, world_from_session.theta_rad)};
  drift_.restore(session.drift.value_or(CarriedPose::at(session.estimate)));
  scale_ = session.scale;
  scale_.turn(world_from_session.theta_rad);
  drift_.move_with_map(session.estimate.world_from_robot, estimate_.world_from_robot);
  motion_.restore(session.motion);
  standing_.reset();
  gate_.restore(session.gate);
  covered_ = session.covered;
  SessionLoopSearch search(back_end_.loop_closer(), keys, first_key,
                           back_end_.state().next_search_path_m - options_.loops.attempt_every_m);
  for (int key = first_key; key < static_cast<int>(keys.size()); ++key) {
    const std::vector<Loop> loops = search.search(keys, key);
    if (loops.empty()) continue;
    for (const Loop& loop : loops) back_end_.add_loop(loop);
    move_keyframes(back_end_.optimized(keys));
    search.update_poses(keys, key);
  }
  back_end_.note_search(keys.back().path_m);
  back_end_.note_closing(keys.back().path_m);
  ++revision_;
  local_map_.rebuild(keyframes_);
}

}  // namespace marco::slam
