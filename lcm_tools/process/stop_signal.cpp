#include "lcm_tools/process/stop_signal.hpp"

#include <csignal>

namespace marco::process {
namespace {

volatile std::sig_atomic_t stop_signal = 0;

void on_stop_signal(int signal_number) { stop_signal = signal_number; }

volatile std::sig_atomic_t interrupt_signal = 0;
std::string outcome_of_interrupt;  // NOLINT: written once, from main

void on_interrupt(int signal_number) {
  if (interrupt_signal != 0) {  // once more: the default way, as soon as this handler ends
    signal(signal_number, SIG_DFL);
    raise(signal_number);
    return;
  }
  interrupt_signal = signal_number;
}

}  // namespace

void catch_interrupts(const std::string& outcome) {
  outcome_of_interrupt = outcome;
  struct sigaction action = {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void end_if_interrupted() {
  if (interrupt_signal != 0) throw Interrupted("interrupted; " + outcome_of_interrupt);
}

int interrupted_by() { return interrupt_signal; }

const std::string& interrupted_outcome() { return outcome_of_interrupt; }

void catch_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = on_stop_signal;  // without SA_RESTART: a waiting poll returns at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stop_requested() { return stop_signal != 0; }

int stopped_by() { return stop_signal; }

}  // namespace marco::process
