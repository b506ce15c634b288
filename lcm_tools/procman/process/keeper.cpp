#include "lcm_tools/procman/process/keeper.hpp"

#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <utility>

#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

// How long descendants may outlive the command's own process, to tidy up.
constexpr int64_t kStragglersUs = 500'000;
constexpr int64_t kKillAgainUs = 5'000;
constexpr int64_t kRetryUs = 10'000;
constexpr int64_t kGrowthPeriodUs = 5'000;
// How long an exit status is kept for a deputy.
constexpr int64_t kLeaveUs = 600'000'000;

std::string notify_path(const std::string& socket_path) {
  return std::filesystem::path(socket_path).replace_extension(kNotifyExtension);
}

}  // namespace

Keeper::Keeper(Descriptor deputy, std::string socket_path)
    : socket_path_(std::move(socket_path)), line_(std::move(deputy), socket_path_) {
  for (const int number : {SIGINT, SIGHUP, SIGQUIT, SIGPIPE, SIGTTOU, SIGTTIN}) {
    std::signal(number, SIG_IGN);
  }
  sigset_t handled;
  sigemptyset(&handled);
  sigaddset(&handled, SIGCHLD);
  sigaddset(&handled, SIGTERM);
  sigprocmask(SIG_BLOCK, &handled, nullptr);
  signals_.reset(signalfd(-1, &handled, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals_.is_open()) throw_errno("signalfd");
  if (prctl(PR_SET_CHILD_SUBREAPER, 1) != 0) throw_errno("PR_SET_CHILD_SUBREAPER");
}

void Keeper::start() {
  state_ = line_.await_run();
  output_.open();
  state_.output_begin = state_.output_shown = state_.output_end;
  line_.listen();
  notify_.open(notify_path(socket_path_));
  terminal_.open();
  main_ = state_.pid = terminal_.start(state_.spec.exec);
  line_.owe_state();
  line_.send_owed(state_);
}

void Keeper::serve() {
  while (phase_ != Phase::released) step();
}

int64_t Keeper::next_timeout_us(int64_t now_us) const {
  int64_t next = now_us + 60'000'000;
  for (const auto& due : {kill_us_, tell_growth_us_, leave_us_, notify_.next_due_us()}) {
    if (due) next = std::min(next, *due);
  }
  if (line_.owes()) next = std::min(next, now_us + kRetryUs);
  return std::max<int64_t>(next - now_us, 0);
}

void Keeper::step() {
  pollfd sources[] = {{signals_.get(), POLLIN, 0},
                      {line_.listener_fd(), POLLIN, 0},
                      {line_.fd(), POLLIN, 0},
                      {phase_ == Phase::running ? terminal_.fd() : -1, POLLIN, 0},
                      {notify_.fd(), POLLIN, 0}};
  poll_for(sources, next_timeout_us(monotonic_us()));
  if (sources[4].revents != 0) notify_.receive(main_);
  if (sources[3].revents != 0) read_output();
  if (sources[0].revents != 0) on_signals();
  if (sources[1].revents != 0 && line_.accept()) {
    line_.owe_state();
    if (phase_ == Phase::finished) line_.owe_ended();
    line_.send_owed(state_);
  }
  if (sources[2].revents != 0) {
    if (const auto message = line_.receive()) on_message(*message);
  }
  on_timers();
}

void Keeper::on_signals() {
  signalfd_siginfo info = {};
  while (read(signals_.get(), &info, sizeof info) == sizeof info) {
    if (info.ssi_signo != SIGTERM) continue;
    begin_stop(state_.spec.stop_signal, state_.spec.stop_time_allowed_s);
    leave_when_finished_ = true;  // the system goes down
    if (phase_ == Phase::finished) leave_us_ = monotonic_us();
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
  kill_within(kStragglersUs);
  if (!stop_begun_) signal_tree(state_.spec.stop_signal);
}

// All orphans become children of a subreaper: without children there are no descendants.
bool Keeper::is_tree_gone() {
  siginfo_t info = {};
  if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) != 0 && errno == ECHILD) return true;
  const std::set<pid_t> survivors = notify_.survivors();
  return !survivors.empty() && descendants_of(getpid(), survivors).empty();
}

void Keeper::finish_if_tree_gone() {
  if (phase_ != Phase::running || main_ != 0 || !is_tree_gone()) return;
  while (read_output()) {
  }
  phase_ = Phase::finished;
  kill_us_.reset();
  tell_growth_us_.reset();
  state_.pid = 0;
  line_.owe_ended();
  line_.send_owed(state_);
  leave_us_ = monotonic_us() + (leave_when_finished_ ? 0 : kLeaveUs);
}

void Keeper::on_timers() {
  const int64_t now_us = monotonic_us();
  if (notify_.is_silent(now_us) && main_ > 0 && state_.cause.empty()) {
    state_.cause = "its heartbeat was silent for 3 s";
    kill_within(0);
  }
  if (kill_us_ && now_us >= *kill_us_) {
    signal_tree(SIGKILL);
    kill_us_ = now_us + kKillAgainUs;  // for processes that were being forked meanwhile
  }
  if (tell_growth_us_ && now_us >= *tell_growth_us_) {
    tell_growth_us_.reset();
    if (!line_.send("grew", state_)) tell_growth_us_ = now_us + kRetryUs;
  }
  line_.send_owed(state_);
  if (leave_us_ && now_us >= *leave_us_ && !line_.is_open()) phase_ = Phase::released;
}

void Keeper::on_message(const KeeperMessage& message) {
  if (message.kind == "stop") begin_stop(message.signal, message.allowed_s);
  if (message.kind == "shown" && message.output_inode == state_.output_inode) {
    state_.output_shown = message.output_shown;
  }
  if (message.kind == "release" && phase_ == Phase::finished) phase_ = Phase::released;
}

bool Keeper::read_output() {
  char bytes[65536];
  const ssize_t size = terminal_.read(bytes, sizeof bytes);
  if (size <= 0) return false;
  output_.write(bytes, static_cast<std::size_t>(size));
  if (!tell_growth_us_) tell_growth_us_ = monotonic_us() + kGrowthPeriodUs;
  return true;
}

void Keeper::kill_within(int64_t us) {
  const int64_t limit_us = monotonic_us() + us;
  kill_us_ = kill_us_ ? std::min(*kill_us_, limit_us) : limit_us;
}

void Keeper::begin_stop(int signal, double allowed_s) {
  kill_within(static_cast<int64_t>(allowed_s * 1e6));
  stop_begun_ = true;
  if (phase_ == Phase::running) signal_tree(signal);
}

void Keeper::signal_tree(int signal) {
  if (main_ > 0) kill(main_, signal);  // before the search for the others
  notify_.receive(main_);
  for (const pid_t pid : descendants_of(getpid(), notify_.survivors())) {
    if (pid != main_) kill(pid, signal);
  }
}

}  // namespace marco::procman
