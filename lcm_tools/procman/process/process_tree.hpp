#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <vector>

#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

/// One line of /proc/PID/stat.
struct ProcessStat {
  pid_t pid = 0;
  pid_t parent = 0;
  int64_t cpu_ticks = 0;  ///< user and system
  int64_t vsize_bytes = 0;
  int64_t rss_bytes = 0;
};

/// All processes there are now.
std::map<pid_t, ProcessStat> read_processes();

/// The descendants of `ancestor`, without itself, parents before children.
std::vector<pid_t> descendants_of(pid_t ancestor, const std::map<pid_t, ProcessStat>& processes);

/// As above, of now; reads no more of /proc than it must.
std::vector<pid_t> descendants_of(pid_t ancestor);

/// Measures loads as changes between calls, which should be about a second apart.
class LoadMeter {
 public:
  /// Memory, and the processor's load since the last call.
  MachineLoad measure_machine();

  /// Fills cpu and memory of each command that runs: of its process and all descendants.
  void measure_commands(std::vector<CommandStatus>& commands);

 private:
  int64_t busy_ticks_ = 0;
  int64_t total_ticks_ = 0;
  int64_t elapsed_ticks_ = 0;  ///< of all cores, between the last two calls
  std::map<pid_t, int64_t> command_ticks_;
};

}  // namespace marco::procman
