#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "lcm_tools/process/bus.hpp"

namespace marco::procman {

/// Publishes on a network that may be down for a while: that must end neither a sheriff nor what a
/// deputy runs. Each outage is reported once.
class PatientPublisher {
 public:
  using Report = std::function<void(const std::string&)>;

  /// @param bus outlives it.
  PatientPublisher(process::Bus& bus, Report report) : bus_(bus), report_(std::move(report)) {}

  template <class Message>
  void publish(const char* channel, const Message& message) {
    try {
      bus_.publish(channel, message);
      is_down_ = false;
    } catch (const std::runtime_error& failure) {
      if (!std::exchange(is_down_, true)) report_(std::string(failure.what()) + "; trying again");
    }
  }

 private:
  process::Bus& bus_;
  Report report_;
  bool is_down_ = false;
};

}  // namespace marco::procman
