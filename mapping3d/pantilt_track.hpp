#pragma once

#include <deque>
#include <optional>

#include "common/samples.hpp"

namespace marco::mapping3d {

struct PanTiltAngles {
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
};

/// The last angles of a pan-tilt, to be asked for any moment between them. A stamp that steps
/// backwards is taken as the truth and what lay at or after it is forgotten, so a clock that jumps
/// spoils the moments about its jump and no others. Keeps the last minutes. Not thread-safe.
class PanTiltTrack {
 public:
  /// @param max_gap  angles are interpolated between states at most so far apart
  /// @param reach    and carried on so far beyond the newest
  PanTiltTrack(Duration max_gap, Duration reach) : max_gap_(max_gap), reach_(reach) {}

  /// @returns whether the stamp is a plausible next one: not at or before the last.
  bool add(const PanTiltState& state);

  /// Nothing before the oldest state, beyond reach, or in a gap on whose sides the angles differ.
  std::optional<PanTiltAngles> at(Utime utime) const;

  bool reaches(Utime utime) const { return !states_.empty() && states_.back().utime >= utime; }

 private:
  Duration max_gap_, reach_;
  std::deque<PanTiltState> states_;
};

}  // namespace marco::mapping3d
