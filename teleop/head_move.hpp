#pragma once

#include <optional>

#include "common/robot_values.hpp"
#include "common/samples.hpp"

namespace marco::teleop {

/// A move of the pan-tilt to ordered angles, judged by what it reports. Pure; reads no clock but
/// the stamps of the states, of which only differences count.
class HeadMove {
 public:
  /// A pan-tilt turns in whole units, 1.5 degrees with the coarsest that is known.
  static constexpr double kNearRad = 0.03;

  /// @param target  with the ordered angles
  explicit HeadMove(const PanTiltCommand& target) : target_(target) {}

  enum class Next {
    wait,
    there,
    ended  ///< it stands elsewhere: at its limit, by another order, or because it does not move
  };
  /// Once for each state that comes after the order was given.
  Next on_state(const PanTiltState& state);

 private:
  PanTiltCommand target_;
  std::optional<PanTiltState> first_;
  PanTiltState moved_;  ///< when it was last seen to move
};

}  // namespace marco::teleop
