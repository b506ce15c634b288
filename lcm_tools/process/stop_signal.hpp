#pragma once

#include <stdexcept>
#include <string>

namespace marco::process {

/// Makes SIGINT, SIGTERM and, unless it is ignored, SIGHUP set a flag instead of ending the
/// process. Call once, from main.
void catch_stop_signals();

/// Whether one of them was received.
bool stop_requested();
/// Which; 0 = none.
int stopped_by();

/// The user interrupted a command.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// For commands that run to an end: these signals make the next end_if_interrupted throw, so
/// that the command can clean up. A second signal ends the process at once. Call from main.
/// @param outcome  reports the remaining state to the user, e.g. "out is unchanged"
void catch_interrupts(const std::string& outcome);

/// @throws Interrupted after a signal. Call it often, e.g. between two events.
void end_if_interrupted();

/// The signal received, 0 = none; and the text given to catch_interrupts.
int interrupted_by();
const std::string& interrupted_outcome();

}  // namespace marco::process
