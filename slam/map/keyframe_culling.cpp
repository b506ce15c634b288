#include "slam/map/keyframe_culling.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

// Of path: keyframes less apart follow each other.
constexpr double kPassM = 8.0;
constexpr int kAtMost = 3;  // times keyframes_per_place
constexpr std::size_t kMatched = 8;

// What a match cannot know of itself; and of a pose that no match confirms.
constexpr double kSigmaM = 0.01, kSigmaDeg = 0.15;
constexpr double kLooseSigmaM = 0.05, kLooseSigmaDeg = 1.0;

struct Older {
  int key;
  double apart;
};

std::vector<Older> of_one_place(const std::vector<Keyframe>& keys,
                                int key,
                                bool loop_closed,
                                const CullingOptions& options) {
  const Keyframe& newer = keys[static_cast<std::size_t>(key)];
  const double turn_rad = deg_to_rad(options.near_turn_deg);
  std::vector<Older> found;
  for (int i = 0; i < key; ++i) {
    const Keyframe& older = keys[static_cast<std::size_t>(i)];
    const Pose2 moved = between(older.world_from_robot, newer.world_from_robot);
    const double panned_rad = normalize_angle(newer.sensor_heading_rad - older.sensor_heading_rad);
    const double apart =
        std::max({moved.translation_m().norm() / options.near_m,
                  std::abs(moved.theta_rad) / turn_rad, std::abs(panned_rad) / turn_rad});
    const bool same_pass = newer.path_m - older.path_m < kPassM;
    if (!same_pass && !loop_closed) continue;
    if (apart <= (same_pass ? 0.5 : 1.0)) found.push_back({i, apart});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Older& a, const Older& b) { return a.apart < b.apart; });
  return found;
}

}  // namespace

std::optional<MergedKeyframe> find_redundant_keyframe(const std::vector<Keyframe>& keys,
                                                      int key,
                                                      bool loop_closed,
                                                      const SurfelMatcher& matcher,
                                                      const CullingOptions& options) {
  const std::vector<Older> older = of_one_place(keys, key, loop_closed, options);
  if (static_cast<int>(older.size()) < options.keyframes_per_place) return std::nullopt;
  const Keyframe& newer = keys[static_cast<std::size_t>(key)];
  const Keyframe& nearest = keys[static_cast<std::size_t>(older.front().key)];
  SurfelPyramid place(matcher.options(), nearest.world_from_robot.translation_m());
  for (std::size_t i = 0; i < std::min(kMatched, older.size()); ++i) {
    const Keyframe& scan = keys[static_cast<std::size_t>(older[i].key)];
    place.add(scan.points_in_robot, scan.world_from_robot);
  }
  const SurfelMatch match =
      matcher.match(place, newer.points_in_robot, newer.world_from_robot, nullptr);
  const Pose2 moved = between(newer.world_from_robot, match.map_from_robot);
  if (match.status != SurfelMatch::Status::no_overlap && match.overlap >= options.min_overlap &&
      moved.translation_m().norm() <= options.max_shift_m &&
      std::abs(moved.theta_rad) <= deg_to_rad(options.max_turn_deg)) {
    return MergedKeyframe{
        older.front().key, between(nearest.world_from_robot, match.map_from_robot),
        rotated(covariance_of(match.information), -match.map_from_robot.theta_rad) +
            diagonal_covariance(kSigmaM, deg_to_rad(kSigmaDeg))};
  }
  if (static_cast<int>(older.size()) < kAtMost * options.keyframes_per_place) return std::nullopt;
  return MergedKeyframe{older.front().key,
                        between(nearest.world_from_robot, newer.world_from_robot),
                        diagonal_covariance(kLooseSigmaM, deg_to_rad(kLooseSigmaDeg))};
}

void check(const CullingState& state, const KeyframeSet& keyframes) {
  const auto count = static_cast<int32_t>(keyframes.keys.size());
  require(state.next >= 0 && state.next <= count && state.until <= count && state.kept >= 0 &&
              state.kept <= count,
          "more keyframes were culled than exist");
}

bool KeyframeCulling::is_due(std::size_t keyframes) const {
  return !is_pending() && static_cast<int>(keyframes) >= state_.kept + options_.after_keyframes;
}

void KeyframeCulling::begin_round(int examined) {
  state_.until = std::max(state_.next, examined - options_.recent_keyframes);
}

std::optional<MergedKeyframe> KeyframeCulling::step(const std::vector<Keyframe>& keys,
                                                    bool loop_closed,
                                                    const SurfelMatcher& matcher) {
  auto merged = find_redundant_keyframe(keys, state_.next, loop_closed, matcher, options_);
  if (merged) {
    --state_.until;
  } else {
    ++state_.next;
  }
  if (!is_pending()) state_.kept = state_.next;
  return merged;
}

}  // namespace marco::slam
