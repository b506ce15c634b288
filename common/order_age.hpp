#pragma once

#include <string>

#include "common/robot_values.hpp"

namespace marco {

/// Why an order with stamp `given` must not be executed at `now`: it is older than kOrderHoldsS, or
/// stamped that far ahead of this computer's clock, so that its age is unknown. One line for the
/// log; "" = it is valid.
std::string why_stale(Utime given, Utime now);

/// A pan-tilt does not report refused orders; its driver counts them. STOP is always executed.
/// @throws std::invalid_argument, always with the same text, for a stale order.
void require_fresh(const PanTiltCommand& command, Utime now);

}  // namespace marco
