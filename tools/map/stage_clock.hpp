#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "lcm_tools/process/progress.hpp"

namespace marco {

/// Wall and CPU time of each stage of a job, and its peak memory.
class StageClock {
 public:
  struct Stage {
    std::string name;
    double wall_s = 0.0;
    double cpu_s = 0.0;  ///< user + system, all threads and processes started
  };
  StageClock() { reset(); }

  /// Shows on a terminal what is done, until the stage ends. Copies share the line.
  void show_stage(const std::string& doing);
  /// Ends a stage, which began at the last call or at the construction.
  void end_stage(const std::string& name);
  const std::vector<Stage>& stages() const { return stages_; }
  double total_wall_s() const;
  double total_cpu_s() const;
  /// Of this process: without what draws the pictures.
  static double peak_memory_mb();

 private:
  void reset();
  std::vector<Stage> stages_;
  std::chrono::steady_clock::time_point wall_;
  double cpu_s_ = 0.0;
  std::shared_ptr<process::Progress> shown_;
};

}  // namespace marco
