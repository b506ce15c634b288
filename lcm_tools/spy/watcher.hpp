#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/spy/receiver.hpp"
#include "lcm_tools/spy/view.hpp"

namespace marco::spy {

/// Looks at the host once a second, and at once when somebody new speaks: who owns which socket,
/// what is lost, why nothing comes. One thread of its own, since a look takes up to a second.
class Watcher {
 public:
  /// All must outlive the watcher.
  Watcher(const diagnosis::UdpUrl& url, SharedModel& shared, const Receiver& receiver);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  /// What was seen last. From any thread.
  void copy_to(Surroundings& around) const;

  enum class Depth { sockets, silence_too };
  /// One look now, from any thread. @param depth silence_too: finds out why no message arrives.
  void look(Depth depth);

 private:
  std::map<Address, Process> name_publishers(const std::vector<Address>& senders) const;
  std::size_t sender_count() const;
  void run();

  diagnosis::UdpUrl url_;
  SharedModel& shared_;
  const Receiver& receiver_;
  diagnosis::Prober prober_;
  std::mutex looking_;        // one look at a time
  mutable std::mutex mutex_;  // guards what was seen
  std::map<Address, Process> publishers_;
  std::vector<Listener> listeners_;
  std::vector<Finding> findings_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace marco::spy
