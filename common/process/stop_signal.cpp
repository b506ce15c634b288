#include "common/process/stop_signal.hpp"

#include <csignal>

namespace marco::process {
namespace {

volatile std::sig_atomic_t stop_flag = 0;

void on_stop_signal(int /*signal*/) { stop_flag = 1; }

}  // namespace

void catch_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = on_stop_signal;  // without SA_RESTART: a waiting poll returns at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stop_requested() { return stop_flag != 0; }

}  // namespace marco::process
