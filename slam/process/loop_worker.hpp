#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "slam/back_end/loop_work.hpp"

namespace marco::slam {

/// A second thread, of lower priority, that looks for loops and optimizes while the first one goes
/// on with its scans. One work at a time goes there by value and comes back by value; nothing else
/// is shared. All members are called by the first thread. The destructor waits for the work.
class LoopWorker {
 public:
  LoopWorker();
  ~LoopWorker();
  LoopWorker(const LoopWorker&) = delete;
  LoopWorker& operator=(const LoopWorker&) = delete;

  /// From start() until take_done() gave it back.
  bool busy() const { return busy_; }
  /// @throws std::logic_error when it is busy.
  void start(LoopWork work);
  /// Nothing while it is still being worked on. Rethrows what the work threw.
  std::optional<LoopWork> take_done();
  /// The same, waiting for it; nothing when there is no work.
  std::optional<LoopWork> wait();

 private:
  void run();
  std::optional<LoopWork> handed_back(std::unique_lock<std::mutex>& lock);

  bool busy_ = false;  ///< the first thread's
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<LoopWork> to_do_, done_;
  std::exception_ptr failure_;
  bool stop_ = false;
  std::thread thread_;  ///< last: starts when all else is made
};

}  // namespace marco::slam
