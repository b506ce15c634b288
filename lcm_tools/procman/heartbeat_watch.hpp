#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

namespace marco::procman {

/// How long promised heartbeats have been silent, without clock or processes. What the watcher
/// itself slept over (a busy or suspended machine, a debugger) does not count: however late a step
/// comes, it counts kStepUs at most. Nor does the time that a process waits for a processor: it
/// does not hang, and a new one would wait, too. Times are monotonic microseconds.
class HeartbeatWatch {
 public:
  static constexpr int64_t kStepUs = 100'000;
  static constexpr int64_t kSilentUs = 3'000'000;

  /// The first beat of a process is the promise of more.
  void on_beat(pid_t pid) { watched_[pid].silent_us = 0; }
  void forget(pid_t pid) { watched_.erase(pid); }

  struct Usage {
    bool is_runnable = false;  ///< it runs, or waits for a processor
    int64_t cpu_ticks = 0;     ///< used since it began

    bool operator==(const Usage&) const = default;
  };
  using UsageOf = std::function<Usage(pid_t)>;

  /// Call at next_due_us(), or more often, after the beats that have come.
  /// @param usage_of  asked for each process that is watched
  /// @returns whether a promised heartbeat was silent for kSilentUs.
  bool step(int64_t now_us, const UsageOf& usage_of);
  /// None while no beat is promised.
  std::optional<int64_t> next_due_us() const;

 private:
  struct Watched {
    int64_t silent_us = 0;
    Usage usage;  ///< at the last step
  };
  std::map<pid_t, Watched> watched_;
  int64_t last_us_ = 0;
};

}  // namespace marco::procman
