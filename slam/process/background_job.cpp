#include "slam/process/background_job.hpp"

#include <sys/resource.h>

#include <chrono>
#include <stdexcept>

#include "slam/process/yield_to_scans.hpp"

namespace marco::slam {

void yield_to_scans() {
  // On Linux this is of the calling thread alone: on one core a scan goes first.
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, kNiceness);
}

bool BackgroundJob::busy() const {
  return answer_.valid() && answer_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

void BackgroundJob::start(std::function<std::string()> job) {
  if (answer_.valid()) throw std::logic_error("background job: one at a time");
  answer_ = std::async(std::launch::async, [job = std::move(job)] {
    yield_to_scans();
    return job();
  });
}

std::string BackgroundJob::take_reply() { return busy() ? std::string() : wait(); }

std::string BackgroundJob::wait() { return answer_.valid() ? answer_.get() : std::string(); }

}  // namespace marco::slam
