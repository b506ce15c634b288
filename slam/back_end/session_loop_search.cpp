#include "slam/back_end/session_loop_search.hpp"

namespace marco::slam {
namespace {

// How far a session is taken to have driven since a loop was last closed: it was just found.
constexpr double kSinceFoundM = 1.0;

}  // namespace

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

}  // namespace marco::slam
