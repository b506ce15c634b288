#include "slam/process/loop_worker.hpp"

#include <stdexcept>
#include <utility>

#include "slam/process/yield_to_scans.hpp"

namespace marco::slam {

LoopWorker::LoopWorker() : thread_([this] { run(); }) {}

LoopWorker::~LoopWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void LoopWorker::start(LoopWork work) {
  if (busy_) throw std::logic_error("loop worker: one work at a time");
  busy_ = true;
  {
    const std::lock_guard lock(mutex_);
    to_do_ = std::move(work);
  }
  changed_.notify_all();
}

std::optional<LoopWork> LoopWorker::take_done() {
  if (!busy_) return std::nullopt;
  std::unique_lock lock(mutex_);
  if (!done_ && !failure_) return std::nullopt;
  return handed_back(lock);
}

std::optional<LoopWork> LoopWorker::wait() {
  if (!busy_) return std::nullopt;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return done_ || failure_; });
  return handed_back(lock);
}

std::optional<LoopWork> LoopWorker::handed_back(std::unique_lock<std::mutex>&) {
  busy_ = false;
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  return std::exchange(done_, std::nullopt);
}

void LoopWorker::run() {
  yield_to_scans();
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || to_do_; });
    if (stop_) return;
    LoopWork work = *std::exchange(to_do_, std::nullopt);
    lock.unlock();
    std::exception_ptr failure;
    try {
      work.run();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    failure_ = failure;
    if (!failure) done_ = std::move(work);
    changed_.notify_all();
  }
}

}  // namespace marco::slam
