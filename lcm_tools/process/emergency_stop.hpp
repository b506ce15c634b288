#pragma once

#include <chrono>
#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::process {

enum class EmergencyStop { engage, release };

/// Stops every base at once and keeps it stopped, or lets it take orders again. Stamped by this
/// host's clock. Sent three times: a datagram may be lost, and the same message again changes
/// nothing. What each base makes of it stands in the note of its BASE_STATUS.
/// @param sender  who, e.g. "marco stop"
/// @param reason  one line for a person
inline void send_emergency_stop(Bus& bus,
                                EmergencyStop what,
                                const std::string& sender,
                                const std::string& reason) {
  emergency_stop_t message;
  message.utime = std::chrono::duration_cast<std::chrono::microseconds>(
                      std::chrono::system_clock::now().time_since_epoch())
                      .count();
  message.engaged = what == EmergencyStop::engage ? 1 : 0;
  message.sender = sender;
  message.reason = reason;
  for (int i = 0; i < 3; ++i) bus.publish(channels::kEmergencyStop, message);
}

}  // namespace marco::process
