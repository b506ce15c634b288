#pragma once

#include <optional>
#include <set>
#include <string>

#include "common/robot_values.hpp"

namespace marco::drivers {

/// Which orders a base may obey at all: none to move while an emergency stop is latched, none that
/// is stale (common/order_age.hpp), none that no robot can drive. A plain STOP is always obeyed.
///
/// The latch lives in this process. A driver that is started again is not latched: it moves only on
/// new orders, and who keeps a stop engaged says so again (marco-teleop does).
class OrderGate {
 public:
  /// @returns why the order is refused, "" = it may be obeyed.
  std::string why_refused(const BaseCommand& order, Utime now) const;

  /// Engages whatever the stamp. A stop that was engaged and released stays released when the same
  /// message comes again, and a release that is older than the stop is passed over: datagrams may
  /// overtake each other.
  /// @returns whether anything changed, the note at least.
  bool on_emergency_stop(const EmergencyStop& message, Utime now);

  bool stopped() const { return latched_.has_value(); }
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
