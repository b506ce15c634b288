#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "lcm_tools/procman/process/command_terminal.hpp"
#include "lcm_tools/procman/process/deputy_line.hpp"
#include "lcm_tools/procman/process/notify_socket.hpp"
#include "lcm_tools/procman/process/output_file.hpp"

namespace marco::procman {

/// One run of one command, from its start until a deputy knows how it ended. A process of its own:
/// it owns the command's terminal, writes its output to a file, sends SIGKILL by its own timer or
/// when a promised heartbeat is missing and, as a subreaper, waits for all descendants to end. It
/// outlives its deputy; a later one finds it by a socket in the runtime folder.
class Keeper {
 public:
  /// See DeputyLine.
  Keeper(Descriptor deputy, std::string socket_path);
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  /// Waits for the deputy's "run" and does it. @throws std::runtime_error when that cannot be done.
  void start();

  /// Until a deputy knows how the command ended.
  void serve();

 private:
  enum class Phase { running, finished, released };

  void step();
  int64_t next_timeout_us(int64_t now_us) const;
  void on_signals();
  void on_main_gone(int raw_status);
  void on_timers();
  void on_message(const KeeperMessage& message);
  bool read_output();
  void begin_stop(int signal, double allowed_s);
  void kill_within(int64_t us);
  void signal_tree(int signal);
  bool is_tree_gone();
  void finish_if_tree_gone();

  std::string socket_path_;
  DeputyLine line_;
  Descriptor signals_;
  CommandTerminal terminal_;
  NotifySocket notify_;
  KeeperMessage state_;  ///< what every message to the deputy carries
  OutputFile output_{state_};
  pid_t main_ = 0;  ///< the command's own process; 0 once it was reaped
  Phase phase_ = Phase::running;
  bool stop_begun_ = false;
  bool leave_when_finished_ = false;
  std::optional<int64_t> kill_us_;
  std::optional<int64_t> tell_growth_us_;
  std::optional<int64_t> leave_us_;  ///< stop waiting for a deputy
};

}  // namespace marco::procman
