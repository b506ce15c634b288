#pragma once

#include <chrono>
#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::process {

/// With these words begins the state of a driver whose device is not there, or does not answer:
/// others tell their users.
inline constexpr const char* kNoDevice = "no device";

/// Tells the others once a second what a live process did so far, on PROCESS_STATUS.
class StatusPublisher {
 public:
  /// @param bus, drops  outlive the publisher.
  StatusPublisher(Bus& bus, std::string process, const DropCounter& drops);

  /// Call after each message or timeout; sends at most once a second.
  /// @param state one line for a person
  void tick(const std::string& state);

  /// Sends at once: an answer to a command should not wait.
  void send(const std::string& state);

  /// Notes how long a message took from its arrival to its result.
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
