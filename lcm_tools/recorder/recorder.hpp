#pragma once

#include <sys/types.h>

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "lcm_tools/recorder/recordings.hpp"

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

struct RecorderOptions {
  std::filesystem::path home;
  std::string url;       ///< LCM's
  std::string piece_mb;  ///< as lcm-logger takes it
};

/// Records with lcm-logger, whole pieces whatever happens: one that crashed is followed by another
/// piece. Keeps reserve_bytes() of the disk free: deletes the oldest recordings, or waits when none
/// may go. One thread.
class Recorder {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param say  called with one line per event
  Recorder(RecorderOptions options, std::function<void(const std::string&)> say);

  /// Call a few times a second. @throws std::runtime_error when lcm-logger is not installed.
  void step(Clock::time_point now);
  void stop(LoggerChild::Told told);

  /// "recording NAME: 12.3 MB, 40.1 MB/min, 50.00 GB free, ..."; "waiting for ..." while it cannot.
  std::string state() const;

 private:
  struct Sample {
    Clock::time_point time;
    int64_t bytes;
  };
  /// @returns what it waits for; "" = there is room
  std::string make_room();
  std::vector<Recording> look();
  void begin();
  void wait_for(const std::string& what);
  void note_end(int code);
  double rate_bytes_per_s() const;

  RecorderOptions options_;
  std::function<void(const std::string&)> say_;
  std::unique_ptr<RunningRecording> recording_;
  std::unique_ptr<LoggerChild> child_;
  std::string waiting_;  ///< for what; "" = it records
  Clock::time_point next_{};
  std::deque<Sample> sizes_;  ///< of the last minute
  DiskSpace disk_;
  int64_t bytes_ = 0;
  int deleted_ = 0;
  bool may_delete_ = false;  ///< more, when room is needed
};

}  // namespace marco::recorder
