#include "lcm_tools/procman/heartbeat_watch.hpp"

#include <algorithm>
#include <utility>

namespace marco::procman {

bool HeartbeatWatch::step(int64_t now_us) {
  const int64_t counted_us = std::min(now_us - std::exchange(last_us_, now_us), kStepUs);
  bool is_silent = false;
  for (auto& [pid, silent_us] : silent_us_) {
    silent_us += counted_us;
    is_silent = is_silent || silent_us >= kSilentUs;
  }
  return is_silent;
}

std::optional<int64_t> HeartbeatWatch::next_due_us() const {
  if (silent_us_.empty()) return std::nullopt;
  return last_us_ + kStepUs;
}

}  // namespace marco::procman
