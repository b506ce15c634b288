#pragma once

#include <cstdint>
#include <optional>

#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/scan_matcher.hpp"

namespace marco::slam {

struct MatchGateState {
  std::optional<Utime> jumps_since;  ///< since then each match jumped as no robot can
  int32_t unmatched = 0;             ///< last scans in a row that fitted nothing, counted to 3

  template <class Visitor>
  void visit(Visitor& v) {
    v("jumps_since", jumps_since);
    v("unmatched", unmatched);
  }
};

/// @throws std::invalid_argument for an impossible count.
void check(const MatchGateState& state);

/// The innovation gate: what becomes of a match that was found. Its rules are those of
/// match_gates.hpp. Not thread-safe.
class MatchGate {
 public:
  const MatchGateState& state() const { return state_; }
  void restore(const MatchGateState& state) { state_ = state; }

  /// Refuses a match that puts the robot where it cannot have driven from the scan before.
  bool refuses(const ScanMatch& match, const Pose2& before, const MotionModel& motion, Utime utime);
  /// Call for each scan that was matched and not refused. @param fits  or is the first of a map
  void note_match(bool fits);
  /// Scans that fit nothing are not drawn, unless nothing fits any more.
  bool may_draw() const;

 private:
  MatchGateState state_;
};

}  // namespace marco::slam
