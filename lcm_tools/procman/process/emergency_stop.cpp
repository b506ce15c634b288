#include "lcm_tools/procman/process/emergency_stop.hpp"

#include <stdexcept>
#include <utility>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::procman {

EmergencyStop::EmergencyStop(process::Bus& bus, process::DropCounter& drops, std::string sender)
    : bus_(bus), stop_(std::move(sender)) {
  constexpr const char* kLayout = "lbss";
  subscribe_checked<marco::emergency_stop_t>(
      bus_, marco::channels::kEmergencyStop, kLayout, drops, [this](const auto& message) {
        stop_.hear({message.utime, message.engaged != 0, message.sender, message.reason});
      });
}

void EmergencyStop::order(Order order, int64_t now_us) {
  process::publish(bus_, stop_.order(order, "the operator's key", wall_clock_us(), now_us));
}

void EmergencyStop::step_to(int64_t now_us) {
  const auto message = stop_.due(now_us);
  if (!message) return;
  try {
    process::publish(bus_, *message);
  } catch (const std::runtime_error&) {
    stop_.on_refused();
  }
}

std::string EmergencyStop::engaged() const {
  const process::EmergencyStopSender::Message& latest = stop_.latest();
  if (!latest.engaged) return "";
  return "by " + latest.sender.substr(0, 40) + ": " + latest.reason.substr(0, 200);
}

}  // namespace marco::procman
