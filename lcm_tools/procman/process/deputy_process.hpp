#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/process/folders.hpp"
#include "lcm_tools/procman/process/keeper_link.hpp"
#include "lcm_tools/procman/process/output_pump.hpp"
#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {

struct DeputyProcessOptions {
  DeputyOptions state;
  std::string lcm_url;         ///< "" = the common default
  std::string keeper_program;  ///< path of marco-procman-keeper
  std::string runtime_folder;  ///< of this deputy: sockets of keepers, a lock
  std::string output_folder;   ///< COMMAND.log per command
  double output_bytes_per_s = 2e6;
  /// A longer output file is set aside as COMMAND.log.1, over the one before: of each command there
  /// are twice as many bytes at most.
  int64_t max_file_bytes = int64_t{64} << 20;
};

/// The hands of a DeputyState: LCM, keepers, files. One thread (LCM has its own for receiving).
class DeputyProcess {
 public:
  explicit DeputyProcess(DeputyProcessOptions options);

  /// Runs until a stop signal, then ends all commands; a second signal ends them at once.
  /// @returns 0; 1 or 2 when there is a deputy of this id already (as the public procman).
  int run();

 private:
  struct Run {
    KeeperLink link;
    KeeperMessage last;  ///< the latest the keeper said
    int64_t inode = 0;   ///< of the file that is read
    bool known = false;  ///< it has said its state
  };

  int find_rival();
  void lock_runtime_folder();
  void adopt_keepers();
  void step();
  void read_keeper(const std::string& id, Run& run);
  void on_keeper_message(const std::string& id, Run& run, const KeeperMessage& message);
  void on_keeper_lost(const std::string& id, const Run& run);
  void do_actions();
  void start(const StartCommand& order);
  void stop(const StopCommand& order);
  void tell(const TellSheriffs& line);
  void publish_info();
  void publish_output();
  void publish_last_output();
  template <class Message>
  void publish(const char* channel, const Message& message);
  std::string output_file(const std::string& id) const;

  DeputyProcessOptions options_;
  Descriptor signals_;
  Descriptor lock_;
  process::DropCounter drops_;
  process::LcmBus bus_;
  DeputyState state_;
  OutputPump pump_;
  LoadMeter meter_;
  MachineLoad machine_;
  std::map<std::string, CommandStatus> loads_;
  std::map<std::string, Run> runs_;
  std::set<std::string> ended_;  ///< runs to forget after this step
  int keepers_started_ = 0;
  bool serving_ = false;  ///< after the search for rivals
  int rival_exit_ = 0;
  int64_t nonce_ = 0;
  bool info_wanted_ = false;
  int64_t next_info_us_ = 0;
  bool leaving_ = false;
  bool network_down_ = false;
};

}  // namespace marco::procman
