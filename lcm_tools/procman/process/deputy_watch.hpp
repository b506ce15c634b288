#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// Says where a sheriff would wait in silence: deputies that are not there, fell silent, or speak
/// the older protocol of libbot2.
class DeputyWatch {
 public:
  /// @param bus outlives it. @param now_us monotonic: the beginning.
  DeputyWatch(process::Bus& bus, int64_t now_us);

  /// Lines for the event log; each thing is said once, until it changes.
  std::vector<std::string> step_to(int64_t now_us, const SheriffState& sheriff);

 private:
  void look_for_missing(const SheriffState& sheriff);
  void look_for_silent(int64_t now_us, const SheriffState& sheriff);

  int64_t began_us_;
  std::set<std::string> missing_;  ///< said to be
  std::set<std::string> silent_;   ///< said to be
  std::set<std::string> older_;    ///< hosts heard on libbot2's channels
  std::vector<std::string> events_;
};

}  // namespace marco::procman
