#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace marco::recorder {

/// lcm-logger, as a child. It ends with its parent, whole to the last event.
class LoggerChild {
 public:
  /// Records into the next piece of `folder`, and into another one after each `piece_mb`.
  /// @throws std::runtime_error when no process can be started.
  LoggerChild(const std::string& url,
              const std::filesystem::path& folder,
              const std::string& piece_mb);
  /// As stop().
  ~LoggerChild();
  LoggerChild(const LoggerChild&) = delete;
  LoggerChild& operator=(const LoggerChild&) = delete;

  /// How it ended, once it has; the number of a signal is negative.
  std::optional<int> ended();

  /// Interrupts it, and waits for its end; kills it after 3 s.
  /// @param told_already  by the supervisor: it gets half a second, since lcm-logger that is
  ///     interrupted twice ends in the midst of an event
  enum class Told { no, already };
  void stop(Told told);

  static constexpr int kNotInstalled = 127;

 private:
  bool ends_within(double seconds);

  pid_t pid_;
};

}  // namespace marco::recorder
