#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "lcm_tools/recorder/logger_child.hpp"
#include "lcm_tools/recorder/recordings.hpp"

namespace marco::recorder {

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
