#pragma once

#include <cstdint>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "web/hub.hpp"
#include "web/process/raw_channels.hpp"
#include "web/process/robot_channels.hpp"

namespace marco::web {

/// From LCM's messages, live or of a recording, to the hub's channels. One thread.
class Page {
 public:
  /// Both outlive it.
  Page(Hub& hub, process::DropCounter& drops);

  void take(const process::RawMessage& message);
  /// Call often. @param now  of the messages' clock
  void step(Utime now);

 private:
  RawChannels raw_;
  RobotChannels robot_;
};

}  // namespace marco::web
