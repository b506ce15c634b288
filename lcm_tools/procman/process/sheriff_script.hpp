#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/procman/process/sheriff_log.hpp"
#include "lcm_tools/procman/script_runner.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// The script that a sheriff runs, fed with messages from the bus and with the clock.
class SheriffScript {
 public:
  /// @param bus, config, log  outlive it.
  SheriffScript(process::Bus& bus, const Config& config, SheriffLog& log)
      : bus_(bus), config_(config), log_(log) {}

  /// Starts a script in place of the one that runs; commands already started are left as they are.
  /// @throws std::invalid_argument when there is none of this name, or it cannot be run.
  void run(const std::string& name);
  void abort();

  /// Runs it as far as it can go now.
  void step(SheriffState& state);
  /// How long step() may wait, at most `max_wait_us`.
  int64_t wait_us(int64_t max_wait_us) const;

  /// Whether a script was started and not aborted by the user since.
  bool is_loaded() const { return runner_.has_value(); }
  bool is_running() const { return state() == ScriptRunner::State::running; }
  /// Finished when there is none.
  ScriptRunner::State state() const {
    return runner_ ? runner_->state() : ScriptRunner::State::finished;
  }
  /// "script go is running, waits for ..."; "" when none is.
  std::string progress_text() const;

 private:
  void note_last_output();

  process::Bus& bus_;
  const Config& config_;
  SheriffLog& log_;
  std::optional<ScriptRunner> runner_;
  std::optional<int64_t> told_wait_us_;  ///< start of the wait that was reported as long
  std::set<std::string> subscribed_;
};

}  // namespace marco::procman
