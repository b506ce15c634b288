#pragma once

#include <set>
#include <string>
#include <vector>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/heartbeat.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/procman/process/deputy_watch.hpp"
#include "lcm_tools/procman/process/emergency_stop.hpp"
#include "lcm_tools/procman/process/patient_publisher.hpp"
#include "lcm_tools/procman/process/sheriff_log.hpp"
#include "lcm_tools/procman/process/sheriff_script.hpp"
#include "lcm_tools/procman/process/stop_signals.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// A sheriff on the network: SheriffState, a script, and a log. It has no main loop and no screen:
/// the headless and the ncurses sheriff drive it. One thread.
class SheriffProcess {
 public:
  /// @param observer publishes nothing but its first question.
  SheriffProcess(const std::string& lcm_url, Config config, bool observer);

  /// Waits up to `max_wait_us` for messages, input on `extra_fd` (-1 = none) or a stop signal;
  /// handles messages, continues the script, sends orders.
  void step(int64_t max_wait_us, int extra_fd);

  /// Stop signals so far.
  int stop_signals() const { return signals_.count(); }

  SheriffScript& script() { return script_; }
  const SheriffScript& script() const { return script_; }
  SheriffLog& log() { return log_; }
  const SheriffLog& log() const { return log_; }
  EmergencyStop& emergency_stop() { return emergency_stop_; }
  const EmergencyStop& emergency_stop() const { return emergency_stop_; }
  SheriffState& state() { return state_; }
  const SheriffState& state() const { return state_; }
  const Config& config() const { return config_; }

  /// Commands that have not done yet what was asked: "lidar: Starting"; empty = all have.
  std::vector<std::string> unsettled() const;

  /// While held, no orders are sent.
  void hold_orders(bool held) { orders_held_ = held; }

  /// Asks the deputies again who is there.
  void ask_who_is_there();

  /// "camera, lidar", "" when nothing runs.
  std::string running_text() const;

  /// Whether orders of a sheriff not seen before came since the last call.
  bool take_other_sheriff_seen() { return std::exchange(others_.is_new, false); }

  /// Changes state and config alike; see SheriffState.
  /// @throws std::invalid_argument for an observer, or while a script runs.
  void put_command(const PlacedCommand& placed);
  void remove_command(const std::string& id);

 private:
  struct OtherSheriffs {
    std::set<std::string> ids;
    bool is_new = false;  ///< one was seen that was not reported yet
  };

  void subscribe();
  void on_other_sheriff(const std::string& id);
  void require_editable() const;
  void send_due_orders();

  Config config_;
  StopSignals signals_;
  process::DropCounter drops_;
  process::LcmBus bus_;
  SheriffLog log_;
  PatientPublisher publisher_;
  SheriffState state_;
  DeputyWatch watch_;
  EmergencyStop emergency_stop_;
  SheriffScript script_;
  OtherSheriffs others_;
  process::Heartbeat heartbeat_;
  bool orders_held_ = false;
};

}  // namespace marco::procman
