#pragma once

#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <ctime>

namespace marco::drivers {

/// CLOCK_MONOTONIC of the kernel itself, which a library that fakes the time does not change.
inline int64_t monotonic_ns() {
  timespec now{};
  static_assert(sizeof now == 2 * sizeof(long), "the kernel's own");
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Memory that a driver and its guardian share.
struct GuardianBeat {
  /// A driver whose last step ended longer ago hangs.
  static constexpr int64_t kSilentNs = 500'000'000;

  std::atomic<int64_t> driver_ns{0};    ///< when the driver's last step ended, monotonic_ns()
  std::atomic<int64_t> guardian_ns{0};  ///< the guardian's last
  std::atomic<bool> taken{false};  ///< the guardian stops the device until the driver clears it
};
static_assert(std::atomic<int64_t>::is_always_lock_free);

/// The first byte of each message between them. From the driver: the line (its descriptor comes
/// along), the bytes that stop its device, "let the line go"; from the guardian: it is at work (its
/// process id follows), the line was taken or let go, a text for the log.
enum class GuardianWord : char {
  line = 'L',
  stop = 'S',
  let_go = 'G',
  ready = 'R',
  done = 'D',
  warning = 'W'
};
inline constexpr int kGuardianSocket = 3, kGuardianMemory = 4;  ///< its descriptors at its start
inline constexpr std::size_t kMostGuardianBytes = 1024;         ///< of a message

}  // namespace marco::drivers
