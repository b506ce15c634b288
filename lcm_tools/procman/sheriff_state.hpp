#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/wire.hpp"

namespace marco::procman {

enum class Status {
  unknown,  ///< its deputy has not reported yet
  starting,
  restarting,
  running,
  stopping,
  stopped_ok,
  stopped_error
};

/// "Starting", "Stopped (error)", ... for a person.
const char* status_text(Status status);

/// A command as the sheriff knows it.
struct SheriffCommand {
  CommandSpec spec;
  std::string label;  ///< another name for scripts, see CommandConfig; "" = none
  std::string deputy;
  int32_t desired_runid = 0;
  bool force_quit = false;
  std::optional<CommandStatus> reported;  ///< none until its deputy has reported
  bool removing = false;                  ///< stopped first, then forgotten

  Status status() const;

  /// Whether its deputy is known to have done what was last asked.
  bool settled() const;

 private:
  friend class SheriffState;
  enum class Intent { none, start, stop, restart } intent_ = Intent::none;
};

struct SheriffDeputy {
  MachineLoad machine;
  int64_t heard_us = 0;  ///< monotonic
};

/// Prefix of the ids of senders of single orders, which the active sheriff adopts.
inline constexpr const char* kGuest = "guest:";

/// The state machine of a sheriff: the public procman's protocol, without clock or network. An
/// order given before its deputy has reported waits, so that no running command is started twice.
class SheriffState {
 public:
  explicit SheriffState(std::string sheriff_id, bool observer = false);

  /// Adds the commands of a config without mistakes.
  void load(const Config& config);

  /// @param now_utime_us the wall clock: information older than 30 s is ignored (not by observers).
  /// @returns events for the log: what changed.
  std::vector<std::string> on_info(const DeputyInfo& info, int64_t now_utime_us, int64_t now_us);

  /// Orders on the bus. An observer learns from them what is wanted; a sheriff adopts a guest's.
  /// @returns whether they are another sheriff's, or a guest's.
  bool on_orders(const Orders& orders);

  /// No-op for a command that runs and is not being stopped. @throws std::invalid_argument for ids
  /// that are not there.
  void start(const std::string& id);
  void stop(const std::string& id);
  void restart(const std::string& id);

  /// Adds a command, or changes the one with its id; a running one keeps running unchanged until it
  /// is restarted. One that moves to another deputy is removed from the old one.
  void put(const PlacedCommand& placed);
  /// Stops it, then leaves it out of the orders, so that its deputy forgets it.
  void remove(const std::string& id);

  bool observer() const { return observer_; }
  void set_observer(bool observer) { observer_ = observer; }

  /// Orders to send now, to deputies that have reported: after a change, and once a second. None
  /// for an observer.
  std::vector<Orders> take_due_orders(int64_t now_utime_us, int64_t now_us);

  /// What an observer orders once of one command: all that is wanted of its deputy, with this one
  /// change. That deputy's own sheriff repeats it from then on, if this id begins with kGuest.
  /// @param action  "start", "stop" or "restart". @throws std::invalid_argument saying why not.
  Orders single_order(const std::string& id,
                      const std::string& action,
                      int64_t now_utime_us,
                      int64_t now_us);

  /// Ids of the commands that are known to run.
  std::vector<std::string> running() const;

  const std::map<std::string, SheriffCommand>& commands() const { return commands_; }
  const std::map<std::string, SheriffDeputy>& deputies() const { return deputies_; }
  const std::string& id() const { return sheriff_id_; }

  /// Ids of the commands meant, by id or label, in the order of their ids.
  std::vector<std::string> commands_of(const Target& target) const;

 private:
  SheriffCommand& command(const std::string& id);
  std::vector<std::string> tell_stale(const DeputyInfo& info, int64_t now_utime_us, int64_t now_us);
  void report(SheriffCommand& command, const CommandStatus& status, bool adopted);
  void note_missing(const std::string& deputy, const std::set<std::string>& listed);
  void settle_first_report(SheriffCommand& command);
  void apply(SheriffCommand& command, SheriffCommand::Intent intent);
  void forget_removed();
  void adopt(const Orders& guests);

  std::string sheriff_id_;
  bool observer_ = false;
  std::map<std::string, SheriffCommand> commands_;
  std::map<std::string, SheriffDeputy> deputies_;
  std::map<std::string, int64_t> orders_sent_us_;
  std::map<std::string, int64_t> stale_told_us_;  ///< by deputy
  std::set<std::string> changed_deputies_;
  /// Per deputy: removed commands that it may still list.
  std::map<std::string, std::set<std::string>> removed_;
};

}  // namespace marco::procman
