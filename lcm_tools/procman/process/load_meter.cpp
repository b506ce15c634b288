#include "lcm_tools/procman/process/load_meter.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kMeasurePeriodUs = 1'000'000;

}  // namespace

void LoadMeter::measure_machine() {
  MachineLoad load;
  std::ifstream memory("/proc/meminfo");
  std::string key;
  std::string unit;
  for (int64_t kilobytes = 0; memory >> key >> kilobytes && std::getline(memory, unit);) {
    if (key == "MemTotal:") load.phys_mem_total_bytes = kilobytes * 1024;
    if (key == "MemFree:") load.phys_mem_free_bytes = kilobytes * 1024;
    if (key == "SwapTotal:") load.swap_total_bytes = kilobytes * 1024;
    if (key == "SwapFree:") load.swap_free_bytes = kilobytes * 1024;
  }
  std::ifstream file("/proc/stat");
  int64_t user = 0;
  int64_t nice = 0;
  int64_t system = 0;
  int64_t idle = 0;
  file >> key >> user >> nice >> system >> idle;
  const int64_t busy = user + nice + system;
  const int64_t total = busy + idle;
  elapsed_ticks_ = total_ticks_ > 0 ? total - total_ticks_ : 0;
  if (elapsed_ticks_ > 0) {
    load.cpu_load = std::clamp(
        static_cast<double>(busy - busy_ticks_) / static_cast<double>(elapsed_ticks_), 0.0, 1.0);
  }
  busy_ticks_ = busy;
  total_ticks_ = total;
  machine_ = load;
}

void LoadMeter::measure_commands(const std::vector<CommandStatus>& commands) {
  const std::map<pid_t, ProcessStat> processes = read_processes();
  std::map<pid_t, int64_t> ticks_now;
  loads_.clear();
  for (const CommandStatus& command : commands) {
    if (command.pid == 0 || !processes.contains(command.pid)) continue;
    CommandStatus& load = loads_.emplace(command.spec.id, command).first->second;
    std::vector<pid_t> members = descendants_of(command.pid, processes);
    members.push_back(command.pid);
    int64_t ticks = 0;
    for (const pid_t pid : members) {
      const ProcessStat& stat = processes.at(pid);
      ticks_now[pid] = stat.cpu_ticks;
      load.mem_vsize_bytes += stat.vsize_bytes;
      load.mem_rss_bytes += stat.rss_bytes;
      const auto before = process_ticks_.find(pid);
      if (before != process_ticks_.end()) ticks += stat.cpu_ticks - before->second;
    }
    if (elapsed_ticks_ > 0) {
      load.cpu_usage =
          std::clamp(static_cast<double>(ticks) / static_cast<double>(elapsed_ticks_), 0.0, 1.0);
    }
  }
  process_ticks_ = std::move(ticks_now);
}

void LoadMeter::fill(DeputyInfo& info, int64_t now_us) {
  if (now_us >= next_us_) {
    measure_machine();
    measure_commands(info.commands);
    next_us_ = now_us + kMeasurePeriodUs;
  }
  info.machine = machine_;
  for (CommandStatus& command : info.commands) {
    const auto load = loads_.find(command.spec.id);
    if (load == loads_.end() || load->second.pid != command.pid) continue;
    command.cpu_usage = load->second.cpu_usage;
    command.mem_vsize_bytes = load->second.mem_vsize_bytes;
    command.mem_rss_bytes = load->second.mem_rss_bytes;
  }
}

}  // namespace marco::procman
