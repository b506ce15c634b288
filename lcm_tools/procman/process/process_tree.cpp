#include "lcm_tools/procman/process/process_tree.hpp"

#include <dirent.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace marco::procman {

std::optional<ProcessStat> read_process(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  // The name is in parentheses and may itself contain any character.
  const std::size_t end_of_name = line.rfind(')');
  if (end_of_name == std::string::npos) return std::nullopt;
  std::istringstream fields(line.substr(end_of_name + 1));
  std::string state;
  std::string skipped;
  ProcessStat stat;
  int64_t user = 0;
  int64_t system = 0;
  int64_t rss_pages = 0;
  stat.pid = pid;
  fields >> state >> stat.parent;
  for (int field = 5; field <= 13; ++field) fields >> skipped;
  fields >> user >> system;
  for (int field = 16; field <= 22; ++field) fields >> skipped;
  fields >> stat.vsize_bytes >> rss_pages;
  stat.is_runnable = state == "R";
  stat.cpu_ticks = user + system;
  stat.rss_bytes = rss_pages * sysconf(_SC_PAGESIZE);
  return fields.fail() ? std::nullopt : std::optional(stat);
}

std::map<pid_t, ProcessStat> read_processes() {
  std::map<pid_t, ProcessStat> processes;
  DIR* folder = opendir("/proc");
  if (folder == nullptr) return processes;
  while (const dirent* entry = readdir(folder)) {
    const pid_t pid = static_cast<pid_t>(std::strtol(entry->d_name, nullptr, 10));
    const auto stat = pid > 0 ? read_process(pid) : std::nullopt;
    if (stat) processes[pid] = *stat;
  }
  closedir(folder);
  return processes;
}

std::vector<pid_t> descendants_of(pid_t ancestor,
                                  const std::map<pid_t, ProcessStat>& processes,
                                  const std::set<pid_t>& without) {
  std::multimap<pid_t, pid_t> children;
  for (const auto& [pid, stat] : processes) {
    if (!without.contains(pid)) children.emplace(stat.parent, pid);
  }
  std::vector<pid_t> found = {ancestor};
  for (std::size_t at = 0; at < found.size(); ++at) {
    const auto [first, last] = children.equal_range(found[at]);
    for (auto child = first; child != last; ++child) found.push_back(child->second);
  }
  found.erase(found.begin());
  return found;
}

// Kernels with CONFIG_PROC_CHILDREN list the children of each thread: a few files instead of one
// for every process of the machine, which would delay a SIGKILL.
std::vector<pid_t> descendants_of(pid_t ancestor, const std::set<pid_t>& without) {
  std::vector<pid_t> found = {ancestor};
  for (std::size_t at = 0; at < found.size(); ++at) {
    const std::string folder = "/proc/" + std::to_string(found[at]) + "/task";
    DIR* threads = opendir(folder.c_str());
    if (threads == nullptr) continue;  // it has ended meanwhile
    while (const dirent* thread = readdir(threads)) {
      if (thread->d_name[0] == '.') continue;
      std::ifstream children(folder + "/" + thread->d_name + "/children");
      if (!children && found[at] == ancestor) {
        closedir(threads);
        return descendants_of(ancestor, read_processes(), without);
      }
      for (pid_t child = 0; children >> child;) {
        if (!without.contains(child)) found.push_back(child);
      }
    }
    closedir(threads);
  }
  found.erase(found.begin());
  return found;
}

}  // namespace marco::procman
