#pragma once

#include <stdexcept>
#include <string>

namespace marco::process {

/// Makes SIGINT and SIGTERM set a flag instead of ending the process. Call once, from main.
void catch_stop_signals();

/// Whether one of them came.
bool stop_requested();

/// The user ended a command that works and ends.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// For a command that works and ends: SIGINT and SIGTERM make the next end_if_interrupted throw, so
/// that it can tidy up; a second one ends the process at once. Call from main.
/// @param outcome  what the user is told then, e.g. "out is as it was"
void catch_interrupts(const std::string& outcome);

/// @throws Interrupted once a signal came. Call it often: between two scans, two events.
void end_if_interrupted();

/// The signal that came, 0 = none; and what catch_interrupts was told.
int interrupted_by();
const std::string& interrupted_outcome();

}  // namespace marco::process
