#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/spy/receiver.hpp"

namespace marco::spy {

/// A log's event time [us], kept where differences do not overflow.
int64_t bounded_time_us(const files::LogEvent& event);

std::string damage_text(const files::LogDamage& damage);

/// Plays a log into a model at its own pace, in a thread; gaps of more than a minute are jumped.
class LogPlayer {
 public:
  struct Options {
    std::string path;
    double speed = 1;       ///< 0 = as fast as it can be read
    double duration_s = 0;  ///< from the first event; 0 = all
  };
  /// @throws std::invalid_argument naming the path when it cannot be read.
  LogPlayer(const Options& options, SharedModel& shared);
  ~LogPlayer();
  LogPlayer(const LogPlayer&) = delete;
  LogPlayer& operator=(const LogPlayer&) = delete;

  /// Stops or starts the log's clock.
  void pause(bool on) { paused_ = on; }
  bool ended() const { return ended_; }
  /// The log's clock.
  int64_t now_us() const { return now_us_; }
  /// What was damaged. Call after ended().
  const files::LogDamage& damage() const { return reader_.damage(); }

 private:
  void run();
  void wait_for(int64_t time_us);

  Options options_;
  SharedModel& shared_;
  files::EventLogReader reader_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> paused_ = false;
  std::atomic<bool> ended_ = false;
  std::atomic<int64_t> now_us_ = 0;
  std::thread thread_;
};

}  // namespace marco::spy
