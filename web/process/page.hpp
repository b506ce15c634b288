#pragma once

#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "web/hub.hpp"
#include "web/model_parts.hpp"
#include "web/process/health_channel.hpp"
#include "web/process/model_requests.hpp"
#include "web/process/orders.hpp"
#include "web/process/procman_channels.hpp"
#include "web/process/raw_channels.hpp"
#include "web/process/robot_channels.hpp"
#include "web/process/source.hpp"

namespace marco::web {

/// From LCM's messages, live or of a recording, to the hub's channels, and from its clients' orders
/// to LCM. One thread.
class Page {
 public:
  /// All outlive it.
  Page(Hub& hub, const Source& source, const SteeringOptions& steering);

  /// Call often. @param now  of the messages' clock
  void step(Utime now);
  std::string state(const std::string& otherwise) const { return health_.state(otherwise); }

 private:
  void take(const process::RawMessage& message);

  RawChannels raw_;
  RobotChannels robot_;
  ProcmanChannels procman_;
  Orders orders_;
  ModelParts model_parts_;
  ModelRequests model_requests_;
  Hub& hub_;
  HealthChannel health_;
};

}  // namespace marco::web
