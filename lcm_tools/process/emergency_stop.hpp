#pragma once

#include <string>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::process {

enum class EmergencyStop { engage, release };

/// Stops every base at once and keeps it stopped, or releases it. Stamped by this host's clock.
/// Sent three times, since a datagram may be lost; repetitions have no effect. Each base answers in
/// the note of its BASE_STATUS.
/// @param sender  e.g. "marco stop"
/// @param reason  one line for the user
inline void send_emergency_stop(Bus& bus,
                                EmergencyStop what,
                                const std::string& sender,
                                const std::string& reason) {
  emergency_stop_t message;
  message.utime = wall_clock_us();
  message.engaged = what == EmergencyStop::engage ? 1 : 0;
  message.sender = sender;
  message.reason = reason;
  for (int i = 0; i < 3; ++i) bus.publish(channels::kEmergencyStop, message);
}

}  // namespace marco::process
