#pragma once

#include <string>
#include <unordered_map>

#include "lcm_tools/procman/config.hpp"

namespace marco::procman {

/// Finds the groups of one config by their paths, so that opening one costs the same however many
/// there are. All groups must be opened through it.
class GroupIndex {
 public:
  /// The group `name` in `parent`, made where there is none. @param path of the group itself.
  GroupConfig& open(GroupConfig& parent, const std::string& name, const std::string& path) {
    const auto [at, is_new] = places_.try_emplace(path, parent.groups.size());
    if (is_new) parent.groups.push_back({name, {}, {}});
    return parent.groups[at->second];
  }

 private:
  std::unordered_map<std::string, std::size_t> places_;  ///< in the parent's `groups`
};

inline std::string group_path(const std::string& parent, const std::string& name) {
  return parent.empty() ? name : parent + "/" + name;
}

}  // namespace marco::procman
