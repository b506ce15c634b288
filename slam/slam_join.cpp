#include "lcm_tools/base/check.hpp"
#include "slam/back_end/session_loop_search.hpp"
#include "slam/slam.hpp"

namespace marco::slam {

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
  estimate_ = {world_from_session * session.estimate.world_from_robot, session.estimate.covariance};
  since_keyframe_ = session.since_keyframe;
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
