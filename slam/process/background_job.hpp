#pragma once

#include <functional>
#include <future>
#include <optional>
#include <string>

namespace marco::slam {

/// One job at a time on a thread of its own, of lower priority, so that no scan waits for a disk.
/// All members are called by one thread. The destructor waits for the job.
class BackgroundJob {
 public:
  bool busy() const;
  /// @param job  returns its result. @throws std::logic_error when the last answer was not taken.
  void start(std::function<std::string()> job);
  /// What the job said, once; "" while it is at work, or when there is none. @throws what it threw.
  std::string take_reply();
  /// The same, waiting for it.
  std::string wait();

 private:
  std::future<std::string> answer_;
};

}  // namespace marco::slam
