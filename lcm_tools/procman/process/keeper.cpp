#include "lcm_tools/procman/process/keeper.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <termios.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lcm_tools/procman/exec_line.hpp"
#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

// What outlives the command's own process may tidy up this long.
constexpr int64_t kStragglersUs = 500'000;
constexpr int64_t kKillAgainUs = 5'000;
constexpr int64_t kRetryUs = 10'000;
// An exit status that nobody has come for by then interests nobody.
constexpr int64_t kLeaveUs = 600'000'000;
constexpr int kExecFailed = 255;

std::optional<std::string> environment_variable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
}

/// In the child, after fork: never returns.
[[noreturn]] void become_command(const std::string& exec, int terminal) {
  setpgid(0, 0);
  for (const int number : {SIGINT, SIGHUP, SIGQUIT, SIGPIPE, SIGTTOU, SIGTTIN, SIGTERM}) {
    std::signal(number, SIG_DFL);
  }
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(terminal, standard);
  close_range(3, ~0U, 0);
  const ExecLine line = parse_exec_line(exec, environment_variable);
  for (const auto& [name, value] : line.assignments) setenv(name.c_str(), value.c_str(), 1);
  if (line.arguments.empty()) {
    dprintf(STDERR_FILENO, "nothing to run in: %s\n", exec.c_str());
    _exit(kExecFailed);
  }
  std::vector<char*> arguments;
  for (const std::string& argument : line.arguments) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execvp(arguments[0], arguments.data());
  dprintf(STDERR_FILENO, "cannot run %s: %s\n", arguments[0], std::strerror(errno));
  _exit(kExecFailed);
}

}  // namespace

Keeper::Keeper(Descriptor deputy, std::string socket_path)
    : deputy_(std::move(deputy)), socket_path_(std::move(socket_path)) {
  for (const int number : {SIGINT, SIGHUP, SIGQUIT, SIGPIPE, SIGTTOU, SIGTTIN}) {
    std::signal(number, SIG_IGN);
  }
  sigset_t heeded;
  sigemptyset(&heeded);
  sigaddset(&heeded, SIGCHLD);
  sigaddset(&heeded, SIGTERM);
  sigprocmask(SIG_BLOCK, &heeded, nullptr);
  signals_.reset(signalfd(-1, &heeded, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals_.is_open()) throw_errno("signalfd");
  if (prctl(PR_SET_CHILD_SUBREAPER, 1) != 0) throw_errno("PR_SET_CHILD_SUBREAPER");
  fcntl(deputy_.get(), F_SETFD, FD_CLOEXEC);
}

Keeper::~Keeper() {
  if (listener_.is_open()) unlink(socket_path_.c_str());
}

void Keeper::start() {
  await_run_message();
  listen_for_deputies();
  open_terminal();
  start_command();
}

void Keeper::serve() {
  while (!released_) step();
}

void Keeper::await_run_message() {
  std::string bytes(kMaxKeeperMessage, '\0');
  const ssize_t size = recv(deputy_.get(), bytes.data(), bytes.size(), 0);
  const auto message = decode_keeper_message(
      std::string_view(bytes).substr(0, static_cast<std::size_t>(std::max<ssize_t>(size, 0))));
  if (!message || message->kind != "run") throw std::runtime_error("expected what to run");
  state_ = *message;
  open_output();
  state_.output_begin = state_.output_shown = state_.output_end;
}

void Keeper::listen_for_deputies() {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (socket_path_.size() >= sizeof address.sun_path) {
    throw std::runtime_error("too long for a socket: " + socket_path_);
  }
  std::copy(socket_path_.begin(), socket_path_.end(), address.sun_path);
  listener_.reset(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listener_.is_open() ||
      bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_.get(), 4) != 0) {
    throw_errno("cannot listen at " + socket_path_);
  }
}

void Keeper::open_terminal() {
  master_.reset(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  if (!master_.is_open() || grantpt(master_.get()) != 0 || unlockpt(master_.get()) != 0) {
    throw_errno("cannot open a terminal");
  }
  slave_.reset(open(ptsname(master_.get()), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!slave_.is_open()) throw_errno("cannot open the terminal's other end");
  termios modes = {};
  tcgetattr(slave_.get(), &modes);
  modes.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  modes.c_oflag &= ~static_cast<tcflag_t>(ONLCR);  // lines end in \n, as in a file
  tcsetattr(slave_.get(), TCSANOW, &modes);
  ioctl(slave_.get(), TIOCSCTTY, 0);
}

void Keeper::start_command() {
  // A stop that comes before the exec must not meet the keeper's own, ignoring, dispositions.
  sigset_t all;
  sigset_t mine;
  sigfillset(&all);
  sigprocmask(SIG_SETMASK, &all, &mine);
  main_ = fork();
  if (main_ < 0) throw_errno("fork");
  if (main_ == 0) become_command(state_.spec.exec, slave_.get());
  sigprocmask(SIG_SETMASK, &mine, nullptr);
  setpgid(main_, main_);
  tcsetpgrp(slave_.get(), main_);
  state_.pid = main_;
  owes_state_ = !send("state");
}

int64_t Keeper::next_timeout_us(int64_t now_us) const {
  int64_t next = now_us + 60'000'000;
  for (const auto& due : {kill_us_, tell_growth_us_, leave_us_}) {
    if (due) next = std::min(next, *due);
  }
  if (deputy_.is_open() && (owes_state_ || owes_ended_)) next = std::min(next, now_us + kRetryUs);
  return std::max<int64_t>(next - now_us, 0);
}

void Keeper::step() {
  pollfd sources[] = {{signals_.get(), POLLIN, 0},
                      {listener_.get(), POLLIN, 0},
                      {deputy_.get(), POLLIN, 0},
                      {finished_ ? -1 : master_.get(), POLLIN, 0}};
  const int64_t wait_us = next_timeout_us(monotonic_us());
  const timespec wait = {wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  if (ppoll(sources, 4, &wait, nullptr) < 0 && errno != EINTR) throw_errno("ppoll");
  if (sources[3].revents != 0) read_output();
  if (sources[0].revents != 0) on_signals();
  if (sources[1].revents != 0) accept_deputy();
  if (sources[2].revents != 0) read_deputy();
  on_timers();
}

void Keeper::on_signals() {
  signalfd_siginfo info = {};
  while (read(signals_.get(), &info, sizeof info) == sizeof info) {
    if (info.ssi_signo != SIGTERM) continue;
    begin_stop(state_.spec.stop_signal, state_.spec.stop_time_allowed_s);
    leave_when_finished_ = true;  // the system goes down
    if (finished_) leave_us_ = monotonic_us();
  }
  int raw_status = 0;
  for (pid_t gone = 0; (gone = waitpid(-1, &raw_status, WNOHANG)) > 0;) {
    if (gone == main_) on_main_gone(raw_status);
  }
  finish_if_tree_gone();
}

void Keeper::on_main_gone(int raw_status) {
  state_.raw_status = raw_status;
  main_ = 0;
  const int64_t limit_us = monotonic_us() + kStragglersUs;
  kill_us_ = kill_us_ ? std::min(*kill_us_, limit_us) : limit_us;
  if (!stop_begun_) signal_tree(state_.spec.stop_signal);
}

// All orphans come to a subreaper: no child left means no descendant left.
void Keeper::finish_if_tree_gone() {
  if (finished_ || main_ != 0) return;
  siginfo_t info = {};
  if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) == 0 || errno != ECHILD) return;
  while (read_output()) {
  }
  finished_ = true;
  kill_us_.reset();
  tell_growth_us_.reset();
  state_.pid = 0;
  owes_ended_ = !send("ended");
  leave_us_ = monotonic_us() + (leave_when_finished_ ? 0 : kLeaveUs);
}

void Keeper::on_timers() {
  const int64_t now_us = monotonic_us();
  if (kill_us_ && now_us >= *kill_us_) {
    signal_tree(SIGKILL);
    kill_us_ = now_us + kKillAgainUs;  // for what was being forked meanwhile
  }
  if (tell_growth_us_ && now_us >= *tell_growth_us_) {
    tell_growth_us_.reset();
    if (!send("grew")) tell_growth_us_ = now_us + kRetryUs;
  }
  if (deputy_.is_open() && owes_state_) owes_state_ = !send("state");
  if (deputy_.is_open() && owes_ended_ && !owes_state_) owes_ended_ = !send("ended");
  if (leave_us_ && now_us >= *leave_us_ && !deputy_.is_open()) released_ = true;
}

void Keeper::begin_stop(int signal, double allowed_s) {
  const int64_t limit_us = monotonic_us() + static_cast<int64_t>(allowed_s * 1e6);
  kill_us_ = kill_us_ ? std::min(*kill_us_, limit_us) : limit_us;
  stop_begun_ = true;
  if (!finished_) signal_tree(signal);
}

void Keeper::signal_tree(int signal) const {
  if (main_ > 0) kill(main_, signal);  // before the search for the others
  for (const pid_t pid : descendants_of(getpid())) {
    if (pid != main_) kill(pid, signal);
  }
}

}  // namespace marco::procman
