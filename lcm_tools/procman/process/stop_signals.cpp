#include "lcm_tools/procman/process/stop_signals.hpp"

#include <pthread.h>
#include <sys/signalfd.h>

#include <csignal>

namespace marco::procman {

StopSignals::StopSignals() {
  std::signal(SIGPIPE, SIG_IGN);
  sigset_t stops;
  sigemptyset(&stops);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&stops, number);
  pthread_sigmask(SIG_BLOCK, &stops, nullptr);
  signals_.reset(signalfd(-1, &stops, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals_.is_open()) throw_errno("signalfd");
}

bool StopSignals::take() {
  signalfd_siginfo info = {};
  if (read(signals_.get(), &info, sizeof info) != sizeof info) return false;
  ++count_;
  return true;
}

}  // namespace marco::procman
