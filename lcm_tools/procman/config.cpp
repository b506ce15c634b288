#include "lcm_tools/procman/config.hpp"

#include <algorithm>
#include <sstream>

#include "lcm_tools/procman/exec_line.hpp"
#include "lcm_tools/procman/group_index.hpp"

namespace marco::procman {
namespace {

void collect(const GroupConfig& group, const std::string& path, std::vector<PlacedCommand>& all) {
  for (const CommandConfig& command : group.commands) all.push_back({path, command});
  for (const GroupConfig& inner : group.groups) {
    collect(inner, group_path(path, inner.name), all);
  }
}

}  // namespace

std::string SourcePlace::text() const {
  return file + ":" + std::to_string(line) + ":" + std::to_string(column);
}

std::string Target::text() const {
  if (kind == TargetKind::everything) return "everything";
  return (kind == TargetKind::command ? "cmd \"" : "group \"") + name + "\"";
}

std::string CommandConfig::wire_exec() const {
  std::string line = environment;
  if (!working_directory.empty()) {
    line += (line.empty() ? "" : " ") + ("env -C " + quote_word(working_directory));
  }
  return line + (line.empty() ? "" : " ") + exec;
}

std::vector<PlacedCommand> all_commands(const Config& config) {
  std::vector<PlacedCommand> all;
  collect(config.root, "", all);
  return all;
}

std::vector<std::string> path_parts(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream text(path);
  for (std::string part; std::getline(text, part, '/');) {
    if (!part.empty()) parts.push_back(part);
  }
  return parts;
}

bool group_is_within(const std::string& group, const std::string& wanted) {
  const std::vector<std::string> inner = path_parts(group);
  const std::vector<std::string> outer = path_parts(wanted);
  return inner.size() >= outer.size() && std::equal(outer.begin(), outer.end(), inner.begin());
}

const ScriptConfig* find_script(const Config& config, const std::string& name) {
  for (const ScriptConfig& script : config.scripts) {
    if (script.name == name) return &script;
  }
  return nullptr;
}

}  // namespace marco::procman
