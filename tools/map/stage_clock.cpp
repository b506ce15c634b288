#include "tools/map/stage_clock.hpp"

#include <sys/resource.h>

namespace marco {
namespace {

rusage usage() {
  rusage result = {};
  getrusage(RUSAGE_SELF, &result);
  return result;
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

void StageClock::reset() {
  const rusage now = usage();
  wall_ = std::chrono::steady_clock::now();
  cpu_s_ = seconds(now.ru_utime) + seconds(now.ru_stime);
}

void StageClock::end_stage(const std::string& name) {
  const auto wall_before = wall_;
  const double cpu_before_s = cpu_s_;
  reset();
  stages_.push_back(
      {name, std::chrono::duration<double>(wall_ - wall_before).count(), cpu_s_ - cpu_before_s});
}

double StageClock::total_wall_s() const {
  double sum = 0.0;
  for (const Stage& stage : stages_) sum += stage.wall_s;
  return sum;
}

double StageClock::total_cpu_s() const {
  double sum = 0.0;
  for (const Stage& stage : stages_) sum += stage.cpu_s;
  return sum;
}

double StageClock::peak_memory_mb() { return static_cast<double>(usage().ru_maxrss) / 1024.0; }

}  // namespace marco
