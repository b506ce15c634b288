#include "procman/config.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "procman/exec_line.hpp"

namespace marco::procman {
namespace {

std::vector<std::string> path_parts(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream text(path);
  for (std::string part; std::getline(text, part, '/');) {
    if (!part.empty()) parts.push_back(part);
  }
  return parts;
}

void merge_group(GroupConfig& into, const GroupConfig& from) {
  into.commands.insert(into.commands.end(), from.commands.begin(), from.commands.end());
  for (const GroupConfig& group : from.groups) {
    auto known = std::find_if(into.groups.begin(), into.groups.end(),
                              [&](const GroupConfig& other) { return other.name == group.name; });
    if (known == into.groups.end()) {
      into.groups.push_back(group);
    } else {
      merge_group(*known, group);
    }
  }
}

Config load(const std::string& path,
            const FileReader& read_file,
            std::vector<std::string>& being_read) {
  const Config file = parse_config(read_file(path), path);
  Config merged;
  being_read.push_back(std::filesystem::path(path).lexically_normal());
  for (const Include& include : file.includes) {
    const std::string next =
        (std::filesystem::path(path).parent_path() / include.path).lexically_normal();
    if (std::find(being_read.begin(), being_read.end(), next) != being_read.end()) {
      throw ConfigError(include.place, "expected a file that does not include itself, got " + next);
    }
    Config included;
    try {
      included = load(next, read_file, being_read);
    } catch (const ConfigError&) {
      throw;
    } catch (const std::runtime_error& failure) {
      throw ConfigError(include.place, failure.what());
    }
    merge_group(merged.root, included.root);
    merged.scripts.insert(merged.scripts.end(), included.scripts.begin(), included.scripts.end());
  }
  being_read.pop_back();
  merge_group(merged.root, file.root);
  merged.scripts.insert(merged.scripts.end(), file.scripts.begin(), file.scripts.end());
  return merged;
}

void collect(const GroupConfig& group, const std::string& path, std::vector<PlacedCommand>& all) {
  for (const CommandConfig& command : group.commands) all.push_back({path, command});
  for (const GroupConfig& inner : group.groups) {
    collect(inner, path.empty() ? inner.name : path + "/" + inner.name, all);
  }
}

bool group_exists(const GroupConfig& group, const std::vector<std::string>& parts, std::size_t at) {
  if (at == parts.size()) return true;
  return std::any_of(group.groups.begin(), group.groups.end(), [&](const GroupConfig& inner) {
    return inner.name == parts[at] && group_exists(inner, parts, at + 1);
  });
}

void find_command_mistakes(const std::vector<PlacedCommand>& commands,
                           std::vector<std::string>& mistakes) {
  std::map<std::string, SourcePlace> known;
  for (const auto& [group, command] : commands) {
    const std::string at = command.place.text() + ": ";
    if (command.id.empty()) {
      mistakes.push_back(at + "expected an id for this command: cmd \"ID\" { ... }");
      continue;
    }
    if (command.deputy.empty()) {
      mistakes.push_back(at + "expected an attribute 'deputy' (or 'host') in command \"" +
                         command.id + "\"");
    }
    const auto [entry, is_new] = known.try_emplace(command.id, command.place);
    if (!is_new) {
      mistakes.push_back(at + "expected another id: there is a command \"" + command.id + "\" at " +
                         entry->second.text());
    }
  }
}

/// Whether running `name` comes to `goal`; `seen` keeps it from going round other cycles.
bool leads_to(const Config& config,
              const std::string& name,
              const std::string& goal,
              std::set<std::string>& seen) {
  if (!seen.insert(name).second) return false;
  const ScriptConfig* script = find_script(config, name);
  if (script == nullptr) return false;
  return std::any_of(
      script->actions.begin(), script->actions.end(), [&](const ScriptAction& action) {
        return action.kind == ActionKind::run_script &&
               (action.script == goal || leads_to(config, action.script, goal, seen));
      });
}

std::string find_action_mistake(const Config& config,
                                const std::set<std::string>& ids,
                                const ScriptConfig& script,
                                const ScriptAction& action) {
  if (action.kind == ActionKind::run_script) {
    if (find_script(config, action.script) == nullptr) {
      return "expected a script of this file, got \"" + action.script + "\"";
    }
    std::set<std::string> seen;
    if (action.script == script.name || leads_to(config, action.script, script.name, seen)) {
      return "expected a script that ends: \"" + script.name + "\" runs itself through \"" +
             action.script + "\"";
    }
    return "";
  }
  if (action.kind == ActionKind::wait_ms) return "";
  if (action.target.kind == TargetKind::command && !ids.contains(action.target.name)) {
    return "expected a command of this file, got \"" + action.target.name + "\"";
  }
  if (action.target.kind == TargetKind::group &&
      !group_exists(config.root, path_parts(action.target.name), 0)) {
    return "expected a group of this file, got \"" + action.target.name + "\"";
  }
  return "";
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

Config load_config(const std::string& path, const FileReader& read_file) {
  std::vector<std::string> being_read;
  return load(path, read_file, being_read);
}

Config load_config(const std::string& path) {
  return load_config(path, [](const std::string& name) {
    std::ifstream file(name, std::ios::binary);
    std::ostringstream text;
    if (!file || !(text << file.rdbuf() || file.peek() == std::ifstream::traits_type::eof())) {
      throw std::runtime_error("cannot read the procman file " + name);
    }
    return text.str();
  });
}

std::vector<PlacedCommand> all_commands(const Config& config) {
  std::vector<PlacedCommand> all;
  collect(config.root, "", all);
  return all;
}

std::vector<std::string> find_mistakes(const Config& config) {
  std::vector<std::string> mistakes;
  const std::vector<PlacedCommand> commands = all_commands(config);
  find_command_mistakes(commands, mistakes);
  std::set<std::string> ids;
  for (const PlacedCommand& placed : commands) ids.insert(placed.command.id);
  std::set<std::string> names;
  for (const ScriptConfig& script : config.scripts) {
    if (!names.insert(script.name).second) {
      mistakes.push_back(script.place.text() + ": expected another name: there are two scripts \"" +
                         script.name + "\"");
    }
    for (const ScriptAction& action : script.actions) {
      const std::string mistake = find_action_mistake(config, ids, script, action);
      if (!mistake.empty()) mistakes.push_back(action.place.text() + ": " + mistake);
    }
  }
  return mistakes;
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
