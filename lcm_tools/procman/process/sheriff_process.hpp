#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/procman/output_log.hpp"
#include "lcm_tools/procman/process/deputy_watch.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/emergency_stop.hpp"
#include "lcm_tools/procman/script_runner.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// A sheriff on the network: SheriffState, a script, and what was heard. Neither screen nor
/// process of its own: headless and ncurses sheriffs drive it. One thread.
class SheriffProcess {
 public:
  /// @param observer publishes nothing but its first question.
  SheriffProcess(const std::string& lcm_url, Config config, bool observer);

  /// Waits up to `max_wait_us` for messages, input on `extra_fd` (-1 = none) or a stop signal;
  /// handles messages, runs the script on, sends orders.
  void step(int64_t max_wait_us, int extra_fd);

  /// How many stop signals have come.
  int stop_signals() const { return stop_signals_; }

  /// Starts a script; one that runs is dropped, what it has started stays.
  /// @throws std::invalid_argument when there is none of this name, or it cannot be run.
  void run_script(const std::string& name);
  void abort_script();
  const ScriptRunner* script() const { return script_ ? &*script_ : nullptr; }

  /// Commands that have not done what was asked: "lidar: Starting"; empty = all have.
  std::vector<std::string> unsettled() const;

  /// While held, no orders are sent.
  void hold_orders(bool held) { orders_held_ = held; }

  /// Asks the deputies again who is there.
  void ask_who_is_there();

  /// "camera, lidar", "" when nothing runs.
  std::string running_text() const;

  EmergencyStop& emergency_stop() { return emergency_stop_; }

  /// Whether orders of a sheriff not seen before came since the last call.
  bool take_other_sheriff_seen();

  /// Changes what the sheriff knows and its config alike; see SheriffState.
  /// @throws std::invalid_argument for an observer, or while a script runs.
  void put_command(const PlacedCommand& placed);
  void remove_command(const std::string& id);

  SheriffState& state() { return state_; }
  const SheriffState& state() const { return state_; }
  const Config& config() const { return config_; }
  const OutputLog& output() const { return output_; }
  const std::deque<std::string>& events() const { return events_; }

  /// Called with each event, and with each whole line of output (id "" = of a deputy itself).
  std::function<void(const std::string& line)> on_event;
  std::function<void(const std::string& id, const std::string& line)> on_output_line;

  /// Notes a line in the event log.
  void note(const std::string& event);

 private:
  void subscribe();
  void require_editable() const;
  void hear_channels_of_script();
  void send_due_orders();
  void step_script();
  void note_last_output(const std::vector<std::string>& ids);
  template <class Message>
  void publish(const char* channel, const Message& message);

  Config config_;
  Descriptor signals_;
  process::DropCounter drops_;
  process::LcmBus bus_;
  SheriffState state_;
  DeputyWatch watch_;
  EmergencyStop emergency_stop_;
  std::optional<ScriptRunner> script_;
  std::optional<int64_t> told_wait_us_;  ///< beginning of the wait that is said to last
  OutputLog output_;
  std::deque<std::string> events_;
  std::set<std::string> heard_channels_;
  std::set<std::string> other_sheriffs_;
  bool other_sheriff_seen_ = false;
  int stop_signals_ = 0;
  bool orders_held_ = false;
  bool network_down_ = false;
};

}  // namespace marco::procman
