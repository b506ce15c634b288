#pragma once

#include <optional>
#include <set>
#include <string>

#include "common/robot_values.hpp"

namespace marco::drivers {

/// Decides which orders a base may obey. Refused are: motion while an emergency stop is latched,
/// stale orders (common/order_age.hpp), and values beyond any robot. A plain STOP always passes.
///
/// The latch outlives this process in a file (StopLatch).
class OrderGate {
 public:
  /// @returns why the order is refused, "" = it may be obeyed.
  std::string why_refused(const BaseCommand& order, Utime now) const;

  /// A stop engages whatever its stamp, but one that was released stays released when the same
  /// message comes again. A release older than the stop is ignored. Datagrams may overtake each
  /// other.
  /// @returns whether anything changed, the note at least.
  bool on_emergency_stop(const EmergencyStop& message, Utime now);

  bool stopped() const { return latched_.has_value(); }
  const std::optional<EmergencyStop>& latched() const { return latched_; }
  /// "emergency stop by SENDER: REASON"; "" = none is latched.
  std::string note() const;

 private:
  void engage(const EmergencyStop& message, Utime now);

  std::optional<EmergencyStop> latched_;  ///< stamped no later than it came
  std::string ignored_release_;
  std::set<Utime> engaged_;   ///< stamps of the stops that are latched
  std::set<Utime> released_;  ///< and of those that were
};

}  // namespace marco::drivers
