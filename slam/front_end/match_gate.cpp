#include "slam/front_end/match_gate.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {

using namespace match_gates;

void check(const MatchGateState& state) {
  require(state.unmatched >= 0 && state.unmatched < 1'000'000,
          "the number of unmatched scans is impossible");
}

bool MatchGate::refuses(const ScanMatch& match,
                        const Pose2& before,
                        const MotionModel& motion,
                        Utime utime) {
  if (!match.usable) return false;
  const bool jumps = motion.exceeds_motion_limits(between(before, match.world_from_robot), utime);
  if (jumps && !state_.jumps_since) state_.jumps_since = utime;
  const bool refused =
      jumps && std::abs((utime - *state_.jumps_since).seconds()) < kJumpsUntilBelievedS;
  if (!refused) state_.jumps_since.reset();
  return refused;
}

void MatchGate::note_match(bool fits) {
  state_.unmatched = fits ? 0 : std::min(state_.unmatched + 1, kUnmatchedUntilDrawn);
}

bool MatchGate::may_draw() const {
  return state_.unmatched == 0 || state_.unmatched >= kUnmatchedUntilDrawn;
}

}  // namespace marco::slam
