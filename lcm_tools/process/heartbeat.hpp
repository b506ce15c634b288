#pragma once

#include <chrono>

namespace marco::process {

/// This process's heartbeat for the supervisor that started it, by systemd's protocol
/// (sd_notify(3)): procman's keeper, or a systemd unit with WatchdogSec=. After the first beat the
/// supervisor kills this process and its children when none comes for a while (procman: 3 s), and
/// starts the command again by its own rules. Without $NOTIFY_SOCKET it does nothing. It never
/// waits and throws nothing. One thread.
class Heartbeat {
 public:
  Heartbeat() noexcept;
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// Call in the loop that must not hang, at least once a second; sends every 0.1 s at most.
  void beat(std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now()) noexcept;

  /// Promises no more beats, until the next one. Before an orderly end: systemd takes it for that.
  void stopping() noexcept;

 private:
  int socket_;  ///< -1 = no supervisor
  std::chrono::steady_clock::time_point next_{};
};

/// For a child of a command that must act after the command was killed, and then ends by itself:
/// procman's keeper neither signals this process nor waits for it. Call it in the child, before it
/// is needed. The child leaves the command's terminal (setsid), whose end would hang it up.
/// @returns whether the keeper got it, within 1 s; false without $NOTIFY_SOCKET.
bool outlive() noexcept;

}  // namespace marco::process
