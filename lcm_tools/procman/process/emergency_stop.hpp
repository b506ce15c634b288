#pragma once

#include <cstdint>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::procman {

/// EMERGENCY_STOP as a sheriff knows and sends it. One thread, the bus's.
class EmergencyStop {
 public:
  using Order = process::EmergencyStop;

  /// @param bus, drops  outlive it. @param sender who the messages say they are from.
  EmergencyStop(process::Bus& bus, process::DropCounter& drops, std::string sender);

  /// Sends it, and again with step_to().
  /// @throws std::runtime_error when the network refuses it; step_to() tries again.
  void order(Order order, int64_t now_us);

  /// Call often. @param now_us monotonic.
  void step_to(int64_t now_us);

  /// "" when it is not engaged, as far as is known; else by whom and why.
  std::string engaged() const;

 private:
  process::Bus& bus_;
  process::EmergencyStopSender stop_;
};

}  // namespace marco::procman
