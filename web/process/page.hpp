#pragma once

#include <cstdint>
#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "web/hub.hpp"
#include "web/model_parts.hpp"
#include "web/process/health_channel.hpp"
#include "web/process/orders.hpp"
#include "web/process/procman_channels.hpp"
#include "web/process/raw_channels.hpp"
#include "web/process/robot_channels.hpp"
#include "web/process/source.hpp"

namespace marco::web {

/// The 3D model is sent when it is asked for: it is refined first, which costs marco-mapping3d
/// seconds. While somebody watches, it is asked for after each sweep.
class ModelRequests {
 public:
  /// @param live  null: nothing is asked for. Outlives it.
  explicit ModelRequests(process::LcmBus* live) : live_(live) {}

  void take(const process::RawMessage& message);
  /// Call often. @param now_us  monotonic
  void step(int64_t now_us, bool somebody_watches);

 private:
  process::LcmBus* live_;
  bool has_new_rows_ = false;  // of a sweep, since the last step
  bool is_due_ = false;        // a sweep that the last model does not hold
  int64_t heard_us_ = 0, asked_us_ = 0;
};

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
