#pragma once

#include <sys/types.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "lcm_tools/procman/heartbeat_watch.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {

/// Of a keeper's second socket, besides the one for deputies.
inline constexpr const char* kNotifyExtension = ".beat";

/// Where a keeper's command speaks to it, by systemd's protocol (sd_notify(3)): datagrams of lines.
///
///     WATCHDOG=1  a heartbeat, and the promise of more
///     STOPPING=1  the sender promises no more
///     OUTLIVES=1  the sender, not the command's own process, is neither signalled nor waited for
///                 (our addition)
///
/// Other lines are ignored, and senders that do not descend from this process.
class NotifySocket {
 public:
  NotifySocket() = default;
  ~NotifySocket();
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  /// Listens at `path`, and names it in this process's environment, in the place of what a
  /// supervisor of the deputy's may have set there. @throws std::runtime_error.
  void open(const std::string& path);
  int fd() const { return socket_.get(); }

  /// Takes what has come. @param main the command's own process.
  void receive(pid_t main);

  /// Whether a promised heartbeat is missing. Call as HeartbeatWatch::step().
  bool is_silent(int64_t now_us);
  std::optional<int64_t> next_due_us() const { return watch_.next_due_us(); }

  /// The processes that have said OUTLIVES=1 and still live.
  std::set<pid_t> survivors();

 private:
  /// By id, with a pidfd each: a later process of the same id is another one.
  using Processes = std::map<pid_t, Descriptor>;

  void on_line(std::string_view line, pid_t sender, pid_t main);

  std::string path_;
  Descriptor socket_;
  HeartbeatWatch watch_;
  Processes beating_;
  Processes survivors_;
};

}  // namespace marco::procman
