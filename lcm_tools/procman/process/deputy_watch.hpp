#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// Reports deputies that a sheriff would otherwise wait for without a word: missing ones, silent
/// ones, and those that speak the older protocol of libbot2.
class DeputyWatch {
 public:
  /// @param bus outlives it. @param now_us monotonic: the beginning.
  DeputyWatch(process::Bus& bus, int64_t now_us);

  /// Events for the log; each state is reported once.
  std::vector<std::string> step_to(int64_t now_us, const SheriffState& sheriff);

 private:
  void look_for_missing(const SheriffState& sheriff);
  void look_for_silent(int64_t now_us, const SheriffState& sheriff);

  int64_t began_us_;
  std::set<std::string> missing_;  ///< reported
  std::set<std::string> silent_;   ///< reported
  std::set<std::string> older_;    ///< hosts on libbot2's channels
  std::vector<std::string> events_;
};

}  // namespace marco::procman
