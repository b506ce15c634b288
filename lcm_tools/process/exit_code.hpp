#pragma once

#include <stdexcept>

namespace marco::process {

/// Exit codes of every program, of the front door and of its scripts. A shell shows a program that
/// a signal ended as 128 + the signal's number.
inline constexpr int kExitDone = 0;      ///< the job was done
inline constexpr int kExitFailed = 1;    ///< refused or failed, with a message on stderr
inline constexpr int kExitUsage = 2;     ///< invalid command line
inline constexpr int kExitWrongMap = 3;  ///< reserved: a map was made, and it is wrong
inline constexpr int kExitSignal = 128;  ///< and the signal's number above it

/// A mistake in the command line that CLI11 cannot detect; run_main returns kExitUsage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @throws UsageError with `message` unless `condition` holds.
inline void require_usage(bool condition, const char* message) {
  if (!condition) throw UsageError(message);
}

}  // namespace marco::process
