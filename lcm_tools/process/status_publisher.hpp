#pragma once

#include <chrono>
#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::process {

/// The state of a driver begins with this when its device is missing or does not answer. Other
/// programs report it to the user.
inline constexpr const char* kNoDevice = "no device";

/// The state of a program begins with this before work of many seconds, in which it sends nothing.
inline constexpr const char* kBusy = "busy: ";

/// Publishes the counts and the state of a live process on PROCESS_STATUS, once a second.
class StatusPublisher {
 public:
  /// @param bus, drops  outlive the publisher.
  StatusPublisher(Bus& bus, std::string process, const DropCounter& drops);

  /// Call after each message or timeout; sends at most once a second.
  /// @param state one line for the user
  void tick(const std::string& state);

  /// Sends at once, for the reply to a command.
  void send(const std::string& state);

  /// Records the time from a message's arrival to its result.
  void add_latency(double seconds);

 private:
  Bus& bus_;
  std::string process_;
  const DropCounter& drops_;
  std::chrono::steady_clock::time_point last_;
  double latency_sum_s_ = 0.0;
  double latency_max_s_ = 0.0;
  int latencies_ = 0;
};

}  // namespace marco::process
