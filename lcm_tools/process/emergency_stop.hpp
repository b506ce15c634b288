#pragma once

#include <string>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/emergency_stop_sender.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::process {

inline void publish(Bus& bus, const EmergencyStopSender::Message& stop) {
  emergency_stop_t message;
  message.utime = stop.utime_us;
  message.engaged = stop.engaged ? 1 : 0;
  message.sender = stop.sender;
  message.reason = stop.reason;
  bus.publish(channels::kEmergencyStop, message);
}

/// Stops every base at once and keeps it stopped, or releases it; for a sender that does not stay
/// to repeat it. Stamped by this host's clock. Sent three times: a datagram may be lost, and a
/// repetition has no effect. Each base answers in the note of its BASE_STATUS.
/// @param sender  e.g. "marco stop"
/// @param reason  one line for the user
inline void send_emergency_stop(Bus& bus,
                                EmergencyStop what,
                                const std::string& sender,
                                const std::string& reason) {
  EmergencyStopSender stop(sender);
  const int64_t now_us = wall_clock_us();
  const EmergencyStopSender::Message& message = stop.order(what, reason, now_us, now_us);
  for (int i = 0; i < 3; ++i) publish(bus, message);
}

}  // namespace marco::process
