#include "tools/map/stage_clock.hpp"

#include <sys/resource.h>

namespace marco {
namespace {

rusage usage(int of_whom) {
  rusage result = {};
  getrusage(of_whom, &result);
  return result;
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double cpu_now_s() {
  const rusage self = usage(RUSAGE_SELF), children = usage(RUSAGE_CHILDREN);
  return seconds(self.ru_utime) + seconds(self.ru_stime) + seconds(children.ru_utime) +
         seconds(children.ru_stime);
}

}  // namespace

void StageClock::reset() {
  wall_ = std::chrono::steady_clock::now();
  cpu_s_ = cpu_now_s();
}

void StageClock::show_stage(const std::string& doing) {
  shown_ = nullptr;  // erased before the next is drawn
  shown_ = std::make_shared<process::Progress>(doing);
  shown_->show();
}

void StageClock::end_stage(const std::string& name) {
  shown_ = nullptr;
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

double StageClock::peak_memory_mb() {
  return static_cast<double>(usage(RUSAGE_SELF).ru_maxrss) / 1024.0;
}

}  // namespace marco
