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

// A terminal that hangs up ends its programs with SIGHUP, unless nohup had it ignored.
void handle_signals(void (*handler)(int), int flags) {
  struct sigaction action = {}, before = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  for (const int number : {SIGINT, SIGTERM}) sigaction(number, &action, nullptr);
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

}  // namespace

void catch_interrupts(const std::string& outcome) {
  outcome_of_interrupt = outcome;
  handle_signals(on_interrupt, SA_RESTART);
}

void end_if_interrupted() {
  if (interrupt_signal != 0) throw Interrupted("interrupted; " + outcome_of_interrupt);
}

int interrupted_by() { return interrupt_signal; }

const std::string& interrupted_outcome() { return outcome_of_interrupt; }

void catch_stop_signals() {
  handle_signals(on_stop_signal, 0);  // without SA_RESTART: a waiting poll returns at once
}

bool stop_requested() { return stop_signal != 0; }

int stopped_by() { return stop_signal; }

}  // namespace marco::process
