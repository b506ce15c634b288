#include <algorithm>

#include "lcm_tools/procman/config.hpp"

namespace marco::procman {
namespace {

// Groups that become empty are removed, too.
bool take_out(GroupConfig& group, const std::string& id) {
  const auto gone =
      std::erase_if(group.commands, [&](const CommandConfig& command) { return command.id == id; });
  bool found = gone > 0;
  for (GroupConfig& inner : group.groups) found = take_out(inner, id) || found;
  std::erase_if(group.groups, [](const GroupConfig& inner) {
    return inner.commands.empty() && inner.groups.empty();
  });
  return found;
}

GroupConfig& group_at(GroupConfig& root, const std::string& path) {
  GroupConfig* group = &root;
  for (const std::string& name : path_parts(path)) {
    const auto inner = std::find_if(group->groups.begin(), group->groups.end(),
                                    [&](const GroupConfig& one) { return one.name == name; });
    if (inner != group->groups.end()) {
      group = &*inner;
    } else {
      group->groups.push_back({name, {}, {}});
      group = &group->groups.back();
    }
  }
  return *group;
}

CommandConfig* find_in(GroupConfig& group, const std::string& id) {
  for (CommandConfig& command : group.commands) {
    if (command.id == id) return &command;
  }
  for (GroupConfig& inner : group.groups) {
    if (CommandConfig* found = find_in(inner, id)) return found;
  }
  return nullptr;
}

}  // namespace

void put_command(Config& config, const PlacedCommand& placed) {
  GroupConfig& group = group_at(config.root, placed.group);
  for (CommandConfig& command : group.commands) {
    if (command.id != placed.command.id) continue;
    command = placed.command;  // keeps its place in the file
    return;
  }
  if (find_in(config.root, placed.command.id) != nullptr) take_out(config.root, placed.command.id);
  group_at(config.root, placed.group).commands.push_back(placed.command);
}

bool remove_command(Config& config, const std::string& id) { return take_out(config.root, id); }

}  // namespace marco::procman
