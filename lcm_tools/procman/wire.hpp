#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// What sheriffs and deputies tell each other, as values (the messages:
/// lcm_tools/lcmtypes/procman).
namespace marco::procman {

struct CommandSpec {
  std::string id;
  std::string exec;     ///< with environment and working directory, see CommandConfig::wire_exec
  std::string group{};  ///< "a/b"
  bool auto_respawn = false;
  int stop_signal = 2;
  double stop_time_allowed_s = 7.0;

  bool operator==(const CommandSpec&) const = default;
};

struct CommandOrder {
  CommandSpec spec;
  int32_t desired_runid = 0;
  bool force_quit = false;
};

/// Everything a sheriff wants of one deputy.
struct Orders {
  int64_t utime_us = 0;  ///< since 1970
  std::string deputy_id;
  std::string sheriff_id;
  std::vector<CommandOrder> commands;
};

struct CommandStatus {
  CommandSpec spec;
  int32_t pid = 0;  ///< 0 = not running
  int32_t actual_runid = 0;
  int32_t exit_code = 0;   ///< raw wait status of the last end
  double cpu_usage = 0.0;  ///< 0..1 of all cores, the command with all its descendants
  int64_t mem_vsize_bytes = 0;
  int64_t mem_rss_bytes = 0;
};

struct MachineLoad {
  double cpu_load = 0.0;  ///< 0..1 of all cores
  int64_t phys_mem_total_bytes = 0;
  int64_t phys_mem_free_bytes = 0;
  int64_t swap_total_bytes = 0;
  int64_t swap_free_bytes = 0;
};

struct DeputyInfo {
  int64_t utime_us = 0;  ///< since 1970
  std::string deputy_id;
  MachineLoad machine;
  std::vector<CommandStatus> commands;
};

/// "exit 3", "killed by signal 15 (Terminated)", from a raw wait status.
std::string describe_exit(int raw_status);

}  // namespace marco::procman
