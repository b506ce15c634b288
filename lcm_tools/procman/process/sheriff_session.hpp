#pragma once

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>

#include "lcm_tools/procman/process/lone_deputy.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"

namespace marco::procman {

/// Why a sheriff cannot bring its own deputy: another "localhost" is running already. Listens for
/// up to 0.6 s and orders nothing meanwhile. @returns "" when there is none.
std::string find_lone_rival(SheriffProcess& sheriff);

/// Where the deputy of -l logs while there is a screen.
std::string lone_deputy_log();

/// A sheriff from start to end, with the deputy of -l if there is one. One thread.
class SheriffSession {
 public:
  /// @param sheriff outlives it.
  SheriffSession(SheriffProcess& sheriff, std::optional<LoneDeputyOptions> lone);

  /// SheriffProcess::step; also keeps the deputy alive.
  void step(int64_t max_wait_us, int extra_fd);

  /// Whether it has a deputy of its own, which ends with it, as all its commands do.
  bool is_lone() const { return lone_.has_value(); }

  /// Reports on stderr what still runs and what happens to it, ends its own deputy, and lists the
  /// recordings of this session. A stop signal meanwhile ends the commands at once.
  void end();

 private:
  void say_what_runs() const;
  void say_recordings() const;

  SheriffProcess& sheriff_;
  std::optional<LoneDeputy> lone_;
  std::time_t began_;
};

}  // namespace marco::procman
