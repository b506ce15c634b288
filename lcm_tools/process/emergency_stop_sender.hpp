#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace marco::process {

enum class EmergencyStop { engage, release };

/// Sends an emergency stop and repeats it: ten times within half a second, because datagrams get
/// lost, and, while it is engaged, once a second, because a base driver that starts later must hear
/// of it. A later release by anybody ends the repetition. Without network and clock.
class EmergencyStopSender {
 public:
  struct Message {
    int64_t utime_us = 0;
    bool engaged = false;
    std::string sender;
    std::string reason;
  };

  explicit EmergencyStopSender(std::string sender) : sender_(std::move(sender)) {}

  /// @param wall_us the stamp; later than that of any received message. @returns what to send at
  /// once.
  const Message& order(EmergencyStop what, std::string reason, int64_t wall_us, int64_t now_us) {
    latest_ = {std::max(wall_us, latest_.utime_us + 1), what == EmergencyStop::engage, sender_,
               std::move(reason)};
    repeats_ = true;
    sent_ = 1;
    next_us_ = now_us + kQuickPeriodUs;
    return latest_;
  }

  /// Anybody's message, ours included.
  void hear(const Message& message) {
    const int64_t utime_us = std::min(message.utime_us, INT64_MAX / 2);
    if (utime_us <= latest_.utime_us) return;  // ours again, or one that is over
    // A stop of ours that another has stopped again stays engaged: theirs is repeated from here.
    repeats_ = repeats_ && latest_.engaged && message.engaged;
    latest_ = message;
    latest_.utime_us = utime_us;
  }

  /// Call often. @param now_us any clock that does not go back. @returns what to send now.
  std::optional<Message> due(int64_t now_us) {
    if (!repeats_ || now_us < next_us_ || (sent_ >= kQuickSends && !latest_.engaged)) {
      return std::nullopt;
    }
    next_us_ = now_us + (sent_ < kQuickSends ? kQuickPeriodUs : kSlowPeriodUs);
    ++sent_;
    return latest_;
  }

  /// The network refused the last one: the quick repetition begins again.
  void on_refused() { sent_ = 0; }

  /// As far as is known.
  bool is_engaged() const { return latest_.engaged; }
  /// The latest of anybody.
  const Message& latest() const { return latest_; }

 private:
  static constexpr int kQuickSends = 10;
  static constexpr int64_t kQuickPeriodUs = 50'000;
  static constexpr int64_t kSlowPeriodUs = 1'000'000;

  std::string sender_;
  Message latest_;
  bool repeats_ = false;
  int sent_ = 0;  ///< times
  int64_t next_us_ = 0;
};

}  // namespace marco::process
