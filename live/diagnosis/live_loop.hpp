#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "live/diagnosis/silence_watch.hpp"

namespace marco::diagnosis {

/// The loop of a live program that works on messages: handles them until a stop signal comes, tells
/// PROCESS_STATUS once a second what it does, and says what is missing.
class LiveLoop {
 public:
  /// What a program says of itself.
  struct Voice {
    std::function<std::string()> state;  ///< one line for PROCESS_STATUS
    /// The next reply to a command, "" = none; may be empty. Replies are logged and sent at once.
    std::function<std::string()> reply = {};
  };

  /// @param options  with the program's drops; all outlive the loop.
  /// @param started  appended to what is logged when the loop starts
  LiveLoop(process::LcmBus& bus,
           const SilenceWatch::Options& options,
           Voice voice,
           const std::string& started = "");

  void run_until_stopped();
  /// Once more at the end: finishing may have completed a command.
  void say_replies();

 private:
  process::LcmBus& bus_;
  process::StatusPublisher status_;
  SilenceWatch silence_;
  Voice voice_;
};

}  // namespace marco::diagnosis
