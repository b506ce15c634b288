#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "drivers/process/guardian_beat.hpp"

namespace marco::drivers {

/// Decides when a guardian stops the device in its driver's place. Has no clock of its own: all
/// times are monotonic_ns().
class GuardianWatch {
 public:
  static constexpr int64_t kSilentNs = GuardianBeat::kSilentNs;
  /// After an emergency stop: a working driver takes a step within this.
  static constexpr int64_t kDeafNs = 100'000'000;
  static constexpr int64_t kRepeatNs = 100'000'000;
  /// After a driver's death the device is stopped for the first time; while the line takes no
  /// bytes, for at most the second.
  static constexpr int64_t kFarewellNs = 1'000'000'000, kInVainNs = 5'000'000'000;
  static constexpr int64_t kLongestWaitNs = 200'000'000;

  enum class Do {
    wait,
    take,  ///< what waits in the line is discarded, and the device stopped
    stop,  ///< again
    leave
  };
  struct Driver {
    int64_t beat_ns = 0;
    bool shares_line = false;
    bool is_taken = false;  ///< and has not noticed it
    bool is_gone = false;
  };

  /// Counts from the first that the driver has not seen.
  void on_emergency_stop(int64_t beat_ns, int64_t now) {
    if (emergency_ns_ <= beat_ns) emergency_ns_ = now;
  }
  /// The line took a stop.
  void on_stopped(int64_t now) {
    if (gone_ns_ && !farewell_ns_) farewell_ns_ = now;
  }

  Do step(const Driver& driver, int64_t now) {
    if (driver.is_gone && !gone_ns_) gone_ns_ = now;
    if (!driver.shares_line) return driver.is_gone ? Do::leave : Do::wait;
    if (farewell_ns_ && now - *farewell_ns_ >= kFarewellNs) return Do::leave;
    if (gone_ns_ && now - *gone_ns_ >= kInVainNs) return Do::leave;
    if (now < (driver.is_taken ? next_stop_ns_ : hangs_at(driver)) && !just_gone(now)) {
      return Do::wait;
    }
    next_stop_ns_ = now + kRepeatNs;
    return driver.is_taken ? Do::stop : Do::take;
  }

  /// How long step() has nothing to do unless something comes.
  int64_t wait_ns(const Driver& driver, int64_t now) const {
    if (!driver.shares_line) return kLongestWaitNs;
    const int64_t due = driver.is_taken ? next_stop_ns_ : hangs_at(driver);
    return std::clamp<int64_t>(due - now, 0, kLongestWaitNs);
  }

 private:
  bool just_gone(int64_t now) const { return gone_ns_ == now; }
  int64_t hangs_at(const Driver& driver) const {
    const int64_t silent = driver.beat_ns + kSilentNs;
    return emergency_ns_ > driver.beat_ns ? std::min(silent, emergency_ns_ + kDeafNs) : silent;
  }

  int64_t emergency_ns_ = 0;
  int64_t next_stop_ns_ = 0;
  std::optional<int64_t> gone_ns_;
  std::optional<int64_t> farewell_ns_;  ///< the first stop after that
};

}  // namespace marco::drivers
