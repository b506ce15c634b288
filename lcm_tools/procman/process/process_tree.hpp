#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace marco::procman {

/// One line of /proc/PID/stat.
struct ProcessStat {
  pid_t pid = 0;
  pid_t parent = 0;
  bool is_runnable = false;  ///< it runs, or waits for a processor
  int64_t cpu_ticks = 0;     ///< user and system
  int64_t vsize_bytes = 0;
  int64_t rss_bytes = 0;
};

/// Nothing where it has ended.
std::optional<ProcessStat> read_process(pid_t pid);

/// All processes there are now.
std::map<pid_t, ProcessStat> read_processes();

/// The descendants of `ancestor`, without itself, parents before children.
/// @param without  processes that are left out, with their own descendants.
std::vector<pid_t> descendants_of(pid_t ancestor,
                                  const std::map<pid_t, ProcessStat>& processes,
                                  const std::set<pid_t>& without = {});

/// As above, of now; reads only the part of /proc that it needs.
std::vector<pid_t> descendants_of(pid_t ancestor, const std::set<pid_t>& without = {});

}  // namespace marco::procman
