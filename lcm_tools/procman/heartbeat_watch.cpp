#include "lcm_tools/procman/heartbeat_watch.hpp"

#include <algorithm>
#include <utility>

namespace marco::procman {

bool HeartbeatWatch::step(int64_t now_us, const UsageOf& usage_of) {
  const int64_t counted_us = std::min(now_us - std::exchange(last_us_, now_us), kStepUs);
  bool is_silent = false;
  for (auto& [pid, watched] : watched_) {
    const Usage usage = usage_of(pid);
    const bool has_waited = usage.is_runnable && usage == watched.usage;
    watched.usage = usage;
    if (!has_waited) watched.silent_us += counted_us;
    is_silent = is_silent || watched.silent_us >= kSilentUs;
  }
  return is_silent;
}

std::optional<int64_t> HeartbeatWatch::next_due_us() const {
  if (watched_.empty()) return std::nullopt;
  return last_us_ + kStepUs;
}

}  // namespace marco::procman
