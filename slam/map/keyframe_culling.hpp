#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/covariance.hpp"
#include "lcm_tools/base/options.hpp"
#include "slam/map/keyframe.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {

struct CullingOptions {
  int after_keyframes = 1000;   ///< culled again when the map has grown by this many
  int recent_keyframes = 200;   ///< the last ones wait: a wrong loop may not be contradicted yet
  int keyframes_per_place = 1;  ///< a place keeps this many before another is merged into them
  double near_m = 0.5;          ///< keyframes of one place are this near ...
  double near_turn_deg = 25;    ///< ... and turned by no more than this; neighbours: half of both
  double min_overlap = 0.80;    ///< of the match with the older ones: else it saw something new
  double max_shift_m = 0.10;  ///< by which that match may move it: else its loop is not closed yet
  double max_turn_deg = 1.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced(
        "after_keyframes", after_keyframes, Limits{1, 1000000},
        "Redundant keyframes are merged each time the map has grown by this number. Less to save "
        "memory.");
    v.advanced(
        "recent_keyframes", recent_keyframes, Limits{0, 1000000},
        "The newest keyframes are never merged, since a wrong loop closure may still be rejected.");
    v.advanced("keyframes_per_place", keyframes_per_place, Limits{1, 1000000},
               "Number of keyframes kept at a place. More for places that look different from "
               "each side.");
  }
};

/// A keyframe that is merged into an older one.
struct MergedKeyframe {
  int into = 0;
  Pose2 into_from_key;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta), frame of the key
};

/// Keyframe culling: finds a keyframe that adds nothing to older ones of its place, so that what is
/// kept grows with the area and not with the time. Enough of them stand there and look the same
/// way, and it matches them where the pose graph says that it is. One that matches them badly saw
/// something new and is kept next to them, up to three times as many.
/// @param key  index; only keyframes before it are compared. Cost: their number, and a match.
/// @param loop_closed  loops were found on both sides of it; until then only those of the same
/// pass are known to be where it is
std::optional<MergedKeyframe> find_redundant_keyframe(const std::vector<Keyframe>& keys,
                                                      int key,
                                                      bool loop_closed,
                                                      const SurfelMatcher& matcher,
                                                      const CullingOptions& options);

struct CullingState {
  int32_t next = 0;   ///< keyframes before this one are culled ...
  int32_t until = 0;  ///< ... and from this one on they wait for the next round
  int32_t kept = 0;   ///< keyframes that the last complete round left

  template <class Visitor>
  void visit(Visitor& v) {
    v("next", next);
    v("until", until);
    v("kept", kept);
  }
};

/// @throws std::invalid_argument for more keyframes than there are.
void check(const CullingState& state, const KeyframeSet& keyframes);

/// Goes through the keyframes, a few for each new one, so that no scan waits for many. A round
/// begins when the map has grown enough and all loops were examined. Not thread-safe.
class KeyframeCulling {
 public:
  explicit KeyframeCulling(const CullingOptions& options) : options_(options) {}

  const CullingState& state() const { return state_; }
  void restore(const CullingState& state) { state_ = state; }
  /// Nothing is left to cull until the map has grown.
  void skip_to(int keyframes) { state_ = {keyframes, keyframes, keyframes}; }

  /// Whether a round may begin once all loops were examined.
  bool is_due(std::size_t keyframes) const;
  /// @param examined  keyframes whose loops were
  void begin_round(int examined);
  bool is_pending() const { return state_.next < state_.until; }
  /// The keyframe that step() will examine.
  int next() const { return state_.next; }
  /// Examines the next keyframe. @returns what it is to be merged into.
  std::optional<MergedKeyframe> step(const std::vector<Keyframe>& keys,
                                     bool loop_closed,
                                     const SurfelMatcher& matcher);

 private:
  CullingOptions options_;
  CullingState state_;
};

}  // namespace marco::slam
