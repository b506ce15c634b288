#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"

namespace marco::procman {

/// One run of one command, from its start until a deputy knows how it ended. A process of its own:
/// it owns the command's terminal, writes every line to the command's file, fires SIGKILL by its
/// own timer and, as a subreaper, sees all descendants to their end. It outlives its deputy and can
/// be found again by a socket in the deputy's runtime folder.
///
/// It is the leader of the terminal's session, so that the death of the command hangs nothing up:
/// what was written but not read yet stays readable.
class Keeper {
 public:
  /// @param deputy SOCK_SEQPACKET, on which "run" comes first.
  /// @param socket_path where a deputy that was started anew finds this keeper.
  Keeper(Descriptor deputy, std::string socket_path);
  ~Keeper();

  /// Waits for the deputy's "run" and does it. @throws std::runtime_error when that cannot be done.
  void start();

  /// Until a deputy knows how the command ended.
  void serve();

 private:
  void await_run_message();
  void open_terminal();
  void start_command();
  void listen_for_deputies();
  void step();
  int64_t next_timeout_us(int64_t now_us) const;
  void on_signals();
  void on_main_gone(int raw_status);
  void on_timers();
  void accept_deputy();
  void read_deputy();
  void on_message(const KeeperMessage& message);
  bool read_output();
  void open_output();
  void write_output(const char* bytes, std::size_t size);
  void begin_new_file();
  void begin_stop(int signal, double allowed_s);
  void signal_tree(int signal) const;
  void finish_if_tree_gone();
  bool send(const char* kind);

  Descriptor deputy_;
  Descriptor listener_;
  Descriptor signals_;
  Descriptor master_;
  Descriptor slave_;
  Descriptor output_;
  std::string socket_path_;
  KeeperMessage state_;  ///< what every message to the deputy carries
  pid_t main_ = 0;       ///< 0 once it was reaped
  bool stop_begun_ = false;
  bool finished_ = false;
  bool released_ = false;
  bool leave_when_finished_ = false;
  bool owes_state_ = false;
  bool owes_ended_ = false;
  std::optional<int64_t> kill_us_;
  std::optional<int64_t> tell_growth_us_;
  std::optional<int64_t> leave_us_;  ///< give up waiting for a deputy
};

}  // namespace marco::procman
