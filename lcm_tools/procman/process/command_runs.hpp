#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/procman/deputy_state.hpp"
#include "lcm_tools/procman/process/keeper_link.hpp"
#include "lcm_tools/procman/process/output_pump.hpp"

namespace marco::procman {

struct CommandRunsOptions {
  std::string keeper_program;  ///< path of marco-procman-keeper
  std::string runtime_folder;  ///< of this deputy: sockets of keepers, a lock
  std::string output_folder;   ///< COMMAND.log per command
  double output_bytes_per_s = 2e6;
  /// A longer output file becomes COMMAND.log.1, replacing the one before: at most twice as many
  /// bytes per command.
  int64_t max_file_bytes = int64_t{64} << 20;
};

/// The runs of a deputy's commands: performs the actions of a DeputyState through keepers, and
/// reports their results to it. One thread.
class CommandRuns {
 public:
  /// @param options, state  outlive it.
  CommandRuns(const CommandRunsOptions& options, DeputyState& state)
      : options_(options), state_(state), pump_(options.output_bytes_per_s) {}

  /// Takes over the keepers that an earlier deputy left.
  void adopt_keepers();

  /// Performs the state's actions until there are none.
  void do_actions();

  /// Descriptors to poll, one per run; read() gets them back with their events.
  std::vector<pollfd> sources() const;
  void read(const std::vector<pollfd>& sources);

  /// The next output to publish; the keepers learn how far it goes.
  std::vector<OutputPiece> take_output(int64_t now_us);
  std::optional<int64_t> next_output_us() const { return pump_.next_due_us(); }

 private:
  struct Run {
    KeeperLink link;
    KeeperMessage last;       ///< the keeper's latest
    int64_t inode = 0;        ///< of the file that is read
    bool is_started = false;  ///< the keeper has sent its state
  };
  using Runs = std::map<std::string, Run>;

  void adopt_keeper(KeeperLink link);
  void on_message(const std::string& id, Run& run, const KeeperMessage& message);
  void on_keeper_lost(const std::string& id, const Run& run);
  void forget_ended();
  void perform(const StartCommand& order);
  void perform(const StopCommand& order);
  void perform(const TellSheriffs& line);

  const CommandRunsOptions& options_;
  DeputyState& state_;
  OutputPump pump_;
  Runs runs_;
  std::set<std::string> ended_;  ///< runs to forget after this step
  int keepers_started_ = 0;
};

}  // namespace marco::procman
