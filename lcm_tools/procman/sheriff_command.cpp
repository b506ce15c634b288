// The status of a command, from orders and reports.
#include <sys/wait.h>

#include <csignal>

#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {
namespace {

bool ended_well(const CommandStatus& status, bool was_stopped) {
  if (status.exit_code == 0) return true;
  if (!was_stopped) return false;
  // A program that catches the signal ends as in a shell: 128 + the signal.
  const int signal = WIFSIGNALED(status.exit_code) ? WTERMSIG(status.exit_code)
                                                   : WEXITSTATUS(status.exit_code) - 128;
  return signal == SIGINT || signal == SIGTERM || signal == SIGKILL ||
         signal == status.spec.stop_signal;
}

}  // namespace

const char* status_text(Status status) {
  switch (status) {
    case Status::unknown:
      return "Unknown";
    case Status::starting:
      return "Starting";
    case Status::restarting:
      return "Restarting";
    case Status::running:
      return "Running";
    case Status::stopping:
      return "Stopping";
    case Status::stopped_ok:
      return "Stopped (OK)";
    case Status::stopped_error:
      return "Stopped (Error)";
  }
  return "";
}

Status SheriffCommand::status() const {
  if (!reported) return Status::unknown;
  const bool runs = reported->pid != 0;
  if (removing && runs) return Status::stopping;
  if (reported->actual_runid != desired_runid && !force_quit) {
    return runs ? Status::restarting : Status::starting;
  }
  if (runs) return force_quit ? Status::stopping : Status::running;
  return ended_well(*reported, force_quit) ? Status::stopped_ok : Status::stopped_error;
}

bool SheriffCommand::settled() const {
  const Status now = status();
  return intent_ == Intent::none && now != Status::starting && now != Status::restarting &&
         now != Status::stopping;
}

}  // namespace marco::procman
