#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

/// Loads of the machine and of commands, measured once a second as changes since the last time.
class LoadMeter {
 public:
  /// When the next measurement is due, monotonic.
  int64_t next_due_us() const { return next_us_; }

  /// Fills in the loads of now, or of the last measurement when none is due: cpu and memory of the
  /// machine, and of each command's process with all its descendants.
  void fill(DeputyInfo& info, int64_t now_us);

 private:
  void measure_machine();
  void measure_commands(const std::vector<CommandStatus>& commands);

  int64_t next_us_ = 0;
  MachineLoad machine_;
  std::map<std::string, CommandStatus> loads_;  ///< by command
  int64_t busy_ticks_ = 0;
  int64_t total_ticks_ = 0;
  int64_t elapsed_ticks_ = 0;  ///< of all cores, between the last two measurements
  std::map<pid_t, int64_t> process_ticks_;
};

}  // namespace marco::procman
