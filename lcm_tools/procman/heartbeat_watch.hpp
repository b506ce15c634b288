#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>

namespace marco::procman {

/// How long promised heartbeats have been silent, without clock or processes. What the watcher
/// itself slept over (a busy or suspended machine, a debugger) does not count: however late a step
/// comes, it counts kStepUs at most. Times are monotonic microseconds.
class HeartbeatWatch {
 public:
  static constexpr int64_t kStepUs = 100'000;
  static constexpr int64_t kSilentUs = 3'000'000;

  /// The first beat of a process is the promise of more.
  void on_beat(pid_t pid) { silent_us_[pid] = 0; }
  void forget(pid_t pid) { silent_us_.erase(pid); }

  /// Call at next_due_us(), or more often, after the beats that have come.
  /// @returns whether a promised heartbeat was silent for kSilentUs.
  bool step(int64_t now_us);
  /// None while no beat is promised.
  std::optional<int64_t> next_due_us() const;

 private:
  std::map<pid_t, int64_t> silent_us_;
  int64_t last_us_ = 0;
};

}  // namespace marco::procman
