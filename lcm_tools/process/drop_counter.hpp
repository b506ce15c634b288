#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace marco::process {

/// Counts messages received and dropped, by cause. Not thread-safe: one per bus thread.
class DropCounter {
 public:
  /// @param warn called with a line for the user, at most once a second per cause; may be empty
  explicit DropCounter(std::function<void(const std::string&)> warn = {})
      : warn_(std::move(warn)) {}

  void count_received() { ++received_; }
  void count(const std::string& cause);

  /// Continues from earlier counts.
  void restore(int64_t received, std::map<std::string, int64_t> by_cause) {
    received_ = received;
    by_cause_ = std::move(by_cause);
  }

  int64_t received() const { return received_; }
  int64_t dropped() const;
  const std::map<std::string, int64_t>& by_cause() const { return by_cause_; }
  /// "12 received, 2 dropped: undecodable 1, ..." for the last line of a process.
  std::string summary() const;

 private:
  std::function<void(const std::string&)> warn_;
  int64_t received_ = 0;
  std::map<std::string, int64_t> by_cause_;
  std::map<std::string, int64_t> last_warning_s_;
};

}  // namespace marco::process
