#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// Runs one script of a config against a sheriff, step by step, without clock or network. Times
/// are monotonic microseconds.
class ScriptRunner {
 public:
  enum class State { running, finished, aborted };

  /// @param config must be free of mistakes; copied.
  /// @throws std::invalid_argument when there is no script of this name, or it cannot be run.
  ScriptRunner(const Config& config, const std::string& name);
  ScriptRunner(const ScriptRunner&) = delete;
  ScriptRunner& operator=(const ScriptRunner&) = delete;

  /// Runs the script as far as it can go now, at most kMostActionsAStep actions: long scripts must
  /// not delay keys and signals.
  State step(SheriffState& sheriff, int64_t now_us);

  /// A message came on a channel that some action waits for.
  void on_message(const std::string& channel, int64_t now_us);

  /// Channels that `wait ... publishing` of this script, and of those it runs, names.
  std::vector<std::string> channels() const;

  /// When to step again, if nothing else happens before.
  std::optional<int64_t> next_due_us() const { return next_due_us_; }

  State state() const { return state_; }
  const std::string& name() const { return name_; }

  /// What it waits for now; "" = nothing.
  std::string waiting_for() const;

  /// When the present wait began; none when it does not wait.
  std::optional<int64_t> waiting_since_us() const;

  /// The commands that the last wait was for.
  const std::vector<std::string>& waited_for() const { return waited_for_; }

  /// Whether a wait has failed since the last call.
  bool take_wait_failed() { return std::exchange(wait_failed_, false); }

  static constexpr int kMostActionsAStep = 1000;

  /// Lines for the event log since the last call.
  std::vector<std::string> take_events();

 private:
  enum class Progress { done, waits, failed };
  struct Frame {
    const ScriptConfig* script;
    std::size_t next = 0;
  };

  Progress run(const ScriptAction& action, SheriffState& sheriff, int64_t now_us);
  Progress check_wait(const ScriptAction& action, const SheriffState& sheriff, int64_t now_us);
  bool is_satisfied(const ScriptAction& action, const SheriffState& sheriff) const;
  Progress give_up(const WaitCondition& wait, const std::string& event);
  void finish(State state, const std::string& event);

  Config config_;
  std::map<std::string, const ScriptConfig*> scripts_;
  std::string name_;
  State state_ = State::running;
  std::vector<Frame> stack_;
  std::optional<int64_t> action_began_us_;  ///< none = the next action has not begun
  std::optional<int64_t> rest_until_us_;
  std::optional<int64_t> next_due_us_;
  std::map<std::string, int64_t> heard_us_;
  std::map<std::string, int32_t> ordered_runids_;  ///< when the action began
  std::vector<std::string> events_;
  std::vector<std::string> waited_for_;
  bool wait_failed_ = false;
};

/// "start cmd "lidar"", for logs and screens.
std::string describe_action(const ScriptAction& action);

}  // namespace marco::procman
