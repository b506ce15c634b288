#include "lcm_tools/procman/process/command_terminal.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "lcm_tools/procman/exec_line.hpp"

namespace marco::procman {
namespace {

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
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);  // see NotifySocket
  const ExecLine line = parse_exec_line(exec, environment_variable);
  for (const auto& [name, value] : line.assignments) setenv(name.c_str(), value.c_str(), 1);
  if (line.arguments.empty()) {
    dprintf(STDERR_FILENO, "no command in: %s\n", exec.c_str());
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

void CommandTerminal::open() {
  master_.reset(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  if (!master_.is_open() || grantpt(master_.get()) != 0 || unlockpt(master_.get()) != 0) {
    throw_errno("cannot open a terminal");
  }
  slave_.reset(::open(ptsname(master_.get()), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!slave_.is_open()) throw_errno("cannot open the terminal's other end");
  termios modes = {};
  tcgetattr(slave_.get(), &modes);
  modes.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  modes.c_oflag &= ~static_cast<tcflag_t>(ONLCR);  // lines end in \n, as in a file
  tcsetattr(slave_.get(), TCSANOW, &modes);
  ioctl(slave_.get(), TIOCSCTTY, 0);
}

pid_t CommandTerminal::start(const std::string& exec) {
  // A stop signal that comes before the exec must not meet the keeper's dispositions, which ignore
  // it.
  sigset_t all;
  sigset_t mine;
  sigfillset(&all);
  sigprocmask(SIG_SETMASK, &all, &mine);
  const pid_t pid = fork();
  if (pid < 0) throw_errno("fork");
  if (pid == 0) become_command(exec, slave_.get());
  sigprocmask(SIG_SETMASK, &mine, nullptr);
  setpgid(pid, pid);
  tcsetpgrp(slave_.get(), pid);
  return pid;
}

}  // namespace marco::procman
