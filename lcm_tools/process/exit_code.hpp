#pragma once

#include <stdexcept>

namespace marco::process {

/// How every program of Marco ends, and the front door and its scripts likewise. A program that a
/// signal ended shows in a shell as 128 + the signal's number.
inline constexpr int kExitDone = 0;      ///< the job was done
inline constexpr int kExitFailed = 1;    ///< refused or failed, with a word on stderr
inline constexpr int kExitUsage = 2;     ///< the command line makes no sense; --help says how
inline constexpr int kExitWrongMap = 3;  ///< reserved: a map was made, and it is wrong
inline constexpr int kExitSignal = 128;  ///< and the signal's number above it

/// A command line that makes no sense for a reason that CLI11 does not see; run_main ends with
/// kExitUsage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @throws UsageError with `message` unless `condition` holds.
inline void require_usage(bool condition, const char* message) {
  if (!condition) throw UsageError(message);
}

}  // namespace marco::process
