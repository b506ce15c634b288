#pragma once

#include <deque>
#include <optional>

#include "common/samples.hpp"

namespace marco {

/// The last angles of a pan-tilt, interpolated for any moment between two states. A stamp that
/// steps back is believed: states at or after it are dropped, so that a clock that jumps spoils
/// only the moments around its jump. Keeps the last minutes. Not thread-safe.
class PanTiltTrack {
 public:
  /// @param max_gap  longest gap between two states that is interpolated
  /// @param reach    how far beyond the newest state angles are extrapolated
  PanTiltTrack() : PanTiltTrack(Duration::from_seconds(1.0), Duration::from_seconds(0.1)) {}
  PanTiltTrack(Duration max_gap, Duration reach) : max_gap_(max_gap), reach_(reach) {}

  /// @returns whether the stamp is a plausible next one: not at or before the last.
  bool add(const PanTiltState& state);

  /// Nothing before the oldest state, beyond reach, or in a gap on whose sides the angles differ.
  std::optional<PanTiltAngles> at(Utime utime) const;

  bool reaches(Utime utime) const { return !states_.empty() && states_.back().utime >= utime; }
  bool empty() const { return states_.empty(); }
  const PanTiltState& newest() const { return states_.back(); }
  void clear() { states_.clear(); }

  /// Its states; the limits are its owner's to know.
  template <class Visitor>
  void visit(Visitor& v) {
    v("states", states_);
  }
  void set_limits(Duration max_gap, Duration reach) {
    max_gap_ = max_gap;
    reach_ = reach;
  }

 private:
  Duration max_gap_, reach_;
  std::deque<PanTiltState> states_;
};

}  // namespace marco
