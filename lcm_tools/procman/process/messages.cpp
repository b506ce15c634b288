#include "lcm_tools/procman/process/messages.hpp"

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {
namespace {

procman_lcm::cmd_t to_message(const CommandSpec& spec) {
  procman_lcm::cmd_t message;
  message.command_id = spec.id;
  message.exec_str = spec.exec;
  message.group = spec.group;
  message.auto_respawn = spec.auto_respawn ? 1 : 0;
  message.stop_signal = static_cast<int8_t>(spec.stop_signal);
  message.stop_time_allowed = static_cast<float>(spec.stop_time_allowed_s);
  return message;
}

CommandSpec from_message(const procman_lcm::cmd_t& message) {
  return {message.command_id,  message.exec_str,
          message.group,       message.auto_respawn != 0,
          message.stop_signal, static_cast<double>(message.stop_time_allowed)};
}

}  // namespace

procman_lcm::deputy_info_t to_message(const DeputyInfo& info) {
  procman_lcm::deputy_info_t message;
  message.utime = info.utime_us;
  message.deputy_id = info.deputy_id;
  message.cpu_load = static_cast<float>(info.machine.cpu_load);
  message.phys_mem_total_bytes = info.machine.phys_mem_total_bytes;
  message.phys_mem_free_bytes = info.machine.phys_mem_free_bytes;
  message.swap_total_bytes = info.machine.swap_total_bytes;
  message.swap_free_bytes = info.machine.swap_free_bytes;
  for (const CommandStatus& status : info.commands) {
    procman_lcm::cmd_status_t& command = message.cmds.emplace_back();
    command.cmd = to_message(status.spec);
    command.pid = status.pid;
    command.actual_runid = status.actual_runid;
    command.exit_code = status.exit_code;
    command.cpu_usage = static_cast<float>(status.cpu_usage);
    command.mem_vsize_bytes = status.mem_vsize_bytes;
    command.mem_rss_bytes = status.mem_rss_bytes;
  }
  message.ncmds = static_cast<int32_t>(message.cmds.size());
  return message;
}

DeputyInfo from_message(const procman_lcm::deputy_info_t& message) {
  DeputyInfo info;
  info.utime_us = message.utime;
  info.deputy_id = message.deputy_id;
  info.machine = {static_cast<double>(message.cpu_load), message.phys_mem_total_bytes,
                  message.phys_mem_free_bytes, message.swap_total_bytes, message.swap_free_bytes};
  for (const procman_lcm::cmd_status_t& command : message.cmds) {
    info.commands.push_back({from_message(command.cmd), command.pid, command.actual_runid,
                             command.exit_code, static_cast<double>(command.cpu_usage),
                             command.mem_vsize_bytes, command.mem_rss_bytes});
  }
  return info;
}

procman_lcm::discovery_t discovery_message(const std::string& transmitter_id, int64_t nonce) {
  procman_lcm::discovery_t message;
  message.utime = wall_clock_us();
  message.transmitter_id = transmitter_id;
  message.nonce = nonce;
  return message;
}

procman_lcm::orders_t to_message(const Orders& orders) {
  procman_lcm::orders_t message;
  message.utime = orders.utime_us;
  message.deputy_id = orders.deputy_id;
  message.sheriff_id = orders.sheriff_id;
  for (const CommandOrder& order : orders.commands) {
    procman_lcm::cmd_desired_t& command = message.cmds.emplace_back();
    command.cmd = to_message(order.spec);
    command.desired_runid = order.desired_runid;
    command.force_quit = order.force_quit ? 1 : 0;
  }
  message.ncmds = static_cast<int32_t>(message.cmds.size());
  return message;
}

Orders from_message(const procman_lcm::orders_t& message) {
  Orders orders{message.utime, message.deputy_id, message.sheriff_id, {}};
  for (const procman_lcm::cmd_desired_t& command : message.cmds) {
    orders.commands.push_back(
        {from_message(command.cmd), command.desired_runid, command.force_quit != 0});
  }
  return orders;
}

}  // namespace marco::procman
