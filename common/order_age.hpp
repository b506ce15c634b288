#pragma once

#include <string>

#include "common/robot_values.hpp"

namespace marco {

/// Why an order with stamp `given` must not be executed at `now`: it is older than kOrderHoldsS, or
/// stamped that far ahead of this computer's clock, so that its age is unknown. One line for the
/// log; "" = it is valid.
std::string why_stale(Utime given, Utime now);

/// For receivers that do not report refused orders, and count them. @param type  of the message
/// @throws std::invalid_argument for a stale order, always with the same text.
void require_fresh(const char* type, Utime given, Utime now);
/// The same; STOP is always executed.
void require_fresh(const PanTiltCommand& command, Utime now);

}  // namespace marco
