#pragma once

#include <string>

#include "common/robot_values.hpp"

namespace marco {

/// Why an order that was given at `given` must not be obeyed at `now`: older than kOrderHoldsS, or
/// stamped that far ahead of this computer's clock (then nobody knows how old it is). One line for
/// a person; "" = it may be obeyed.
std::string why_stale(Utime given, Utime now);

/// A pan-tilt tells nothing of refused orders: who hears one counts it. STOP is always obeyed.
/// @throws std::invalid_argument, always with the same text, for an order that is stale.
void require_fresh(const PanTiltCommand& command, Utime now);

}  // namespace marco
