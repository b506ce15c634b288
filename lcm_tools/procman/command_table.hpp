#pragma once

#include <set>
#include <string>
#include <vector>

#include "lcm_tools/procman/sheriff_state.hpp"

namespace marco::procman {

/// What a status looks like; of a group, what its members have in common.
enum class StatusColour { none, orange, green, yellow, red, grey };

StatusColour colour_of(Status status);

/// A line of the sheriff's table: a group with the sums of its members, or a command.
struct TableRow {
  bool is_group = false;
  bool folded = false;  ///< of a group: its members have no rows
  int depth = 0;        ///< groups it stands in
  std::string name;     ///< last part of the group's path, or the command's id
  std::string target;   ///< the group's path, or the command's id
  std::string deputy;   ///< "" of a group on several
  std::string status;
  StatusColour colour = StatusColour::none;
  double cpu_usage = 0.0;  ///< 0..1
  int64_t rss_bytes = 0;
  std::string exec;
};

/// The table from top to bottom: commands without group, then the groups with theirs.
/// @param folded paths of the groups to be shown as one line.
/// @param now_us monotonic: what a deputy silent for 5 s said last is shown grey, with a '?'.
std::vector<TableRow> table_rows(const SheriffState& sheriff,
                                 const std::set<std::string>& folded,
                                 int64_t now_us);

}  // namespace marco::procman
