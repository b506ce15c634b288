#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/procman/output_log.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"
#include "web/hub.hpp"

namespace marco::web {

/// page/commands and page/output, and orders to procman. It watches as a sheriff that only
/// observes; for an order it repeats what was wanted of the deputy, with the one change. One
/// thread.
class ProcmanChannels {
 public:
  struct Trouble {
    std::string command, text;
  };

  /// All outlive it. @param orders  null: none are sent, as for a recording
  ProcmanChannels(Hub& hub, process::DropCounter& drops, process::Bus& in, process::Bus* orders);

  /// Call often. @param now_us  monotonic
  void step(int64_t now_us);
  void send_known(Hub::ClientId client, uint32_t channel);

  /// @param action  "start", "stop" or "restart". @returns what was ordered, for the user.
  /// @throws std::invalid_argument saying why not.
  std::string order(const std::string& command, const std::string& action);

  /// Commands that ended with an error.
  std::vector<Trouble> troubles() const;
  /// Programs, by the names that they run under, of commands that were stopped or are done.
  std::vector<std::string> ended_programs() const;

 private:
  std::string commands_json(int64_t now_us) const;
  void take_line(const std::string& command, const std::string& line);

  Hub& hub_;
  process::Bus* orders_;
  uint32_t commands_, output_, log_;
  procman::SheriffState state_;
  procman::OutputLog lines_;
  std::deque<std::pair<std::string, std::string>> newest_;  // command, line
  std::size_t newest_bytes_ = 0;
  uint64_t next_line_ = 0;
  std::string told_;
  int64_t looked_us_ = 0, told_us_ = 0;
};

}  // namespace marco::web
