#pragma once

#include <cstdint>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::procman {

/// EMERGENCY_STOP as a sheriff knows and sends it. One thread, the bus's.
class EmergencyStop {
 public:
  /// @param bus, drops  outlive it. @param sender who the messages say they are from.
  EmergencyStop(process::Bus& bus, process::DropCounter& drops, std::string sender);

  enum class Order { engage, release };
  /// Sends it, and again with each step_to() as long as nobody has sent a later one: a base driver
  /// that is started meanwhile must learn of it.
  /// @throws std::runtime_error when the network refuses it; step_to() tries again.
  void order(Order order, int64_t now_us);

  /// Call often. @param now_us monotonic.
  void step_to(int64_t now_us);

  /// "" when it is not engaged, as far as is known; else by whom and why.
  const std::string& engaged() const { return engaged_; }

 private:
  void note(bool engaged, const std::string& sender, const std::string& reason);
  void send();

  process::Bus& bus_;
  std::string sender_;
  std::string engaged_;
  int64_t utime_us_ = 0;  ///< of the latest message, ours or another's
  bool is_ours_ = false;  ///< the latest one is
  bool engages_ = false;  ///< what the latest one says
  int sent_ = 0;          ///< times, of the latest one of ours
  int64_t next_send_us_ = 0;
};

}  // namespace marco::procman
