#pragma once

#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/process/command_runs.hpp"
#include "lcm_tools/procman/process/load_meter.hpp"
#include "lcm_tools/procman/process/patient_publisher.hpp"
#include "lcm_tools/procman/process/stop_signals.hpp"

namespace marco::procman {

struct DeputyProcessOptions {
  DeputyOptions state;
  CommandRunsOptions runs;
  std::string lcm_url;  ///< "" = the common default
};

/// A deputy on the network: a DeputyState, the runs of its commands, and messages. One thread (LCM
/// has its own for receiving).
class DeputyProcess {
 public:
  explicit DeputyProcess(DeputyProcessOptions options);

  /// Runs until a stop signal, then ends all commands; a second signal ends them at once.
  /// @returns 0; 1 or 2 when there is a deputy of this id already (as the public procman).
  int run();

 private:
  struct RivalSearch {
    int64_t nonce = 0;
    int exit_code = 0;     ///< not 0: another deputy of this name answered
    bool is_over = false;  ///< orders are taken only then
  };

  void subscribe();
  void find_rival();
  void step();
  void publish_info();
  void publish_output();
  void publish_last_output();

  DeputyProcessOptions options_;
  StopSignals signals_;
  Descriptor lock_;
  process::DropCounter drops_;
  process::LcmBus bus_;
  PatientPublisher publisher_;
  DeputyState state_;
  CommandRuns runs_;
  LoadMeter meter_;
  RivalSearch rivals_;
  bool info_wanted_ = false;
  bool leaving_ = false;
};

}  // namespace marco::procman
