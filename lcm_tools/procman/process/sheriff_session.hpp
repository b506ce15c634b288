#pragma once

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>

#include "lcm_tools/procman/process/lone_deputy.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

namespace marco::procman {

/// Why a sheriff must not bring its own deputy here: one "localhost" is at work already. Listens
/// for up to 0.6 s and orders nothing meanwhile. @returns "" when the place is free.
std::string find_lone_rival(SheriffProcess& sheriff);

/// Where the deputy of -l writes its messages while there is a screen.
std::string lone_deputy_log();

/// A sheriff from its start to its end, with the deputy it may bring along. One thread.
class SheriffSession {
 public:
  /// @param sheriff outlives it.
  SheriffSession(SheriffProcess& sheriff, std::optional<LoneDeputyOptions> lone);

  /// SheriffProcess::step; also keeps the deputy alive.
  void step(int64_t max_wait_us, int extra_fd);

  /// With a deputy of its own, which ends with it together with all commands.
  bool is_lone() const { return lone_.has_value(); }

  /// Says on stderr what still runs and what becomes of it, ends the deputy of its own, and says
  /// where recordings of this session lie. A stop signal meanwhile ends the commands at once.
  void end();

 private:
  void say_what_runs() const;
  void say_recordings() const;

  SheriffProcess& sheriff_;
  std::optional<LoneDeputy> lone_;
  std::time_t began_;
};

}  // namespace marco::procman
