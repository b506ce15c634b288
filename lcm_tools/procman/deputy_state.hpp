#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

struct DeputyOptions {
  std::string deputy_id;
  /// Only these exec strings are started, and a command left out of orders keeps running.
  /// None = any sheriff may run anything (--accept-any-orders).
  std::optional<std::set<std::string>> allowed_execs = std::set<std::string>{};
  int max_crashes = 20;         ///< consecutive short runs before respawning stops
  double healthy_run_s = 10.0;  ///< a run this long resets the count
  double max_orders_age_s = 60.0;
  std::size_t max_commands = 1000;
};

/// Actions that the process must perform. Times are monotonic microseconds.
struct StartCommand {
  CommandSpec spec;
  int32_t runid = 0;
};
struct StopCommand {
  std::string id;
  int signal = 2;
  double allowed_s = 7.0;  ///< until SIGKILL
};
/// A message of the deputy, shown with the command's output. id "" = about no command.
struct TellSheriffs {
  std::string id;
  std::string text;
  enum class Tone { warning, information } tone = Tone::warning;
};
using DeputyAction = std::variant<StartCommand, StopCommand, TellSheriffs>;

/// The state machine of a deputy: the rules of the public procman's protocol, without processes,
/// clock or network. What differs: a restart takes one order (the start follows the end), crash
/// loops end, refused orders are visible.
class DeputyState {
 public:
  explicit DeputyState(DeputyOptions options);

  /// An order with an exec string that is not allowed does not change a command that runs or waits
  /// for its respawn; a stop is obeyed whatever its exec string.
  /// @param now_utime_us the wall clock, for the age of the orders.
  void on_orders(const Orders& orders, int64_t now_utime_us, int64_t now_us);

  /// The command ordered by StartCommand runs as `pid`.
  void on_started(const std::string& id, int32_t pid);

  /// The command and all its descendants are gone. Also after a start that failed.
  /// @param cause  why the keeper killed it; "" = it did not, or the time to stop was over.
  void on_ended(const std::string& id,
                int raw_status,
                int64_t now_us,
                const std::string& cause = {});

  /// Takes over a command that was running before this deputy started.
  void adopt(const CommandSpec& spec, int32_t runid, int32_t pid, int64_t now_us);

  /// Starts the respawns that are due. Call at next_due_us().
  void on_time(int64_t now_us);
  std::optional<int64_t> next_due_us() const;

  /// Stops all commands and ignores further orders. A second call sends SIGKILL at once.
  void shut_down();
  bool all_ended() const;

  /// What to do now, in order; each is given once.
  std::vector<DeputyAction> take_actions();

  /// Whether something to publish has changed since the last call.
  bool take_changed();

  /// pid, run ids and exit codes; loads are 0.
  std::vector<CommandStatus> commands() const;

  struct Refusals {
    int64_t stale = 0;     ///< orders older than max_orders_age_s
    int64_t exec = 0;      ///< starts of commands that are not in the scripts
    int64_t too_many = 0;  ///< commands beyond max_commands
    int64_t left_out = 0;  ///< running commands that a sheriff left out of its orders
  };
  const Refusals& refusals() const { return refusals_; }

 private:
  struct Entry {
    CommandSpec spec;
    enum class Life { stopped, starting, running } life = Life::stopped;
    int32_t pid = 0;
    int32_t reported_runid = 0;  ///< of the last start that got a pid, or that failed
    int32_t runid = 0;           ///< of the last start
    int exit_code = 0;
    bool should_run = false;
    bool stopping = false;
    bool remove_when_ended = false;
    bool told_left_out = false;
    std::optional<int32_t> next_runid;  ///< start this when it has ended
    int64_t started_us = 0;
    int64_t delay_ms = 0;
    int crashes = 0;
    std::optional<int64_t> respawn_us;
    std::optional<int64_t> refused_us;  ///< when an order for another exec was last refused
  };

  void on_order(const CommandOrder& order, int64_t now_us);
  bool is_allowed(const std::string& exec) const;
  bool refuse_change(Entry& entry, const CommandOrder& order, int64_t now_us);
  void tell_end(const Entry& entry, int raw_status, const std::string& cause);
  void on_order_running(Entry& entry, const CommandOrder& order);
  void on_left_out(const std::set<std::string>& ordered);
  void start(Entry& entry, int32_t runid, int64_t now_us);
  void stop(Entry& entry, double allowed_s);
  void plan_respawn(Entry& entry, int64_t now_us);
  void tell(const std::string& id,
            std::string text,
            TellSheriffs::Tone tone = TellSheriffs::Tone::warning);

  DeputyOptions options_;
  std::map<std::string, Entry> entries_;
  std::vector<DeputyAction> actions_;
  Refusals refusals_;
  bool changed_ = false;
  bool shutting_down_ = false;
  std::optional<int64_t> last_stale_tell_us_;
};

}  // namespace marco::procman
