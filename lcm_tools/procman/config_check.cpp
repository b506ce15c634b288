// What is wrong with a file that parses: with all of it, or with some of its scripts.
#include <set>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/group_index.hpp"

namespace marco::procman {
namespace {

using IdsTaken = std::set<std::string>;

void take_ids(const GroupConfig& group, IdsTaken& taken) {
  for (const CommandConfig& command : group.commands) taken.insert(command.id);
  for (const GroupConfig& inner : group.groups) take_ids(inner, taken);
}

/// Gives duplicate ids a number, in the order of all_commands().
class IdMaker {
 public:
  explicit IdMaker(const Config& config) { take_ids(config.root, taken_); }

  void visit(GroupConfig& group) {
    for (CommandConfig& command : group.commands) {
      if (command.id.empty()) continue;
      Seen& seen = seen_.try_emplace(command.id, Seen{command.place, 0}).first->second;
      if (++seen.count == 1) continue;
      command.label = command.id;
      while (!taken_.insert(command.id = numbered(command.label, seen.count)).second) ++seen.count;
      warnings.push_back(command.place.text() + ": there is a command \"" + command.label +
                         "\" at " + seen.first.text() + " already; this one is called \"" +
                         command.id + "\", and a script that names \"" + command.label +
                         "\" means all of them");
    }
    for (GroupConfig& inner : group.groups) visit(inner);
  }

  std::vector<std::string> warnings;

 private:
  struct Seen {
    SourcePlace first;
    int count = 0;
  };
  static std::string numbered(const std::string& label, int number) {
    return label + " (" + std::to_string(number) + ")";
  }

  IdsTaken taken_;
  std::map<std::string, Seen> seen_;
};

void collect_paths(const GroupConfig& group, const std::string& path, std::set<std::string>& all) {
  all.insert(path);
  for (const GroupConfig& inner : group.groups) {
    collect_paths(inner, group_path(path, inner.name), all);
  }
}

std::string without_needless_slashes(const std::string& path) {
  std::string out;
  for (const std::string& part : path_parts(path)) out = group_path(out, part);
  return out;
}

/// Linear in the number of scripts and run_script actions.
class ScriptChecker {
 public:
  explicit ScriptChecker(const Config& config) : config_(config) {
    for (const PlacedCommand& placed : all_commands(config)) {
      commands_.insert(placed.command.id);
      if (!placed.command.label.empty()) commands_.insert(placed.command.label);
    }
    collect_paths(config.root, "", groups_);
    for (const ScriptConfig& script : config.scripts) scripts_.emplace(script.name, &script);
  }

  std::map<std::string, std::vector<std::string>> check() {
    for (const ScriptConfig& script : config_.scripts) {
      for (const ScriptAction& action : script.actions) check_names(script, action);
    }
    const std::set<std::string> endless = find_long_and_endless();
    for (const std::string& name : endless) {
      for (const ScriptAction& action : scripts_.at(name)->actions) {
        if (action.kind != ActionKind::run_script || !endless.contains(action.script)) continue;
        add(name, action,
            "expected a script that ends: running \"" + action.script + "\" forms a cycle");
      }
    }
    blame_callers();
    return std::move(mistakes_);
  }

 private:
  void add(const std::string& script, const ScriptAction& action, const std::string& what) {
    mistakes_[script].push_back(action.place.text() + ": " + what);
  }

  void check_names(const ScriptConfig& script, const ScriptAction& action) {
    if (action.kind == ActionKind::run_script) {
      if (scripts_.contains(action.script)) {
        callers_[action.script].push_back({&script, &action});
      } else {
        add(script.name, action, "expected a script of this file, got \"" + action.script + "\"");
      }
    } else if (action.kind != ActionKind::wait_ms) {
      const Target& target = action.target;
      if (target.kind == TargetKind::command && !commands_.contains(target.name)) {
        add(script.name, action, "expected a command of this file, got \"" + target.name + "\"");
      }
      if (target.kind == TargetKind::group &&
          !groups_.contains(without_needless_slashes(target.name))) {
        add(script.name, action, "expected a group of this file, got \"" + target.name + "\"");
      }
    }
  }

  /// @returns scripts in a cycle or leading into one: those left after removing, again and again,
  /// scripts that run no other (Kahn's topological sort). Of these the actions are counted.
  std::set<std::string> find_long_and_endless() {
    std::map<std::string, std::size_t> open_calls;
    std::map<std::string, int64_t> actions;
    for (const auto& [name, calls] : callers_) {
      for (const Call& call : calls) ++open_calls[call.caller->name];
    }
    std::set<std::string> endless;
    std::vector<std::string> ending;
    for (const auto& [name, script] : scripts_) {
      endless.insert(name);
      if (!open_calls.contains(name)) ending.push_back(name);
    }
    while (!ending.empty()) {
      const std::string name = std::move(ending.back());
      ending.pop_back();
      endless.erase(name);
      int64_t& count = actions[name];
      count += static_cast<int64_t>(scripts_.at(name)->actions.size());
      if (count > kMostScriptActions) {
        count = 0;  // who runs it cannot be run anyhow
        mistakes_[name].push_back(scripts_.at(name)->place.text() + ": expected at most " +
                                  std::to_string(kMostScriptActions) +
                                  " actions, with those of the scripts that it runs");
      }
      const auto calls = callers_.find(name);
      if (calls == callers_.end()) continue;
      for (const Call& call : calls->second) {
        actions[call.caller->name] += count;
        if (--open_calls[call.caller->name] == 0) ending.push_back(call.caller->name);
      }
    }
    return endless;
  }

  /// A script that runs one that cannot be run cannot be run itself.
  void blame_callers() {
    std::vector<std::string> broken;
    for (const auto& [name, mistakes] : mistakes_) broken.push_back(name);
    while (!broken.empty()) {
      const std::string name = std::move(broken.back());
      broken.pop_back();
      const auto calls = callers_.find(name);
      if (calls == callers_.end()) continue;
      for (const auto& [caller, action] : calls->second) {
        if (mistakes_.contains(caller->name)) continue;
        add(caller->name, *action, "expected a script that can be run, got \"" + name + "\"");
        broken.push_back(caller->name);
      }
    }
  }

  struct Call {
    const ScriptConfig* caller;
    const ScriptAction* action;
  };

  const Config& config_;
  std::set<std::string> commands_;
  std::set<std::string> groups_;
  std::map<std::string, const ScriptConfig*> scripts_;
  std::map<std::string, std::vector<Call>> callers_;  ///< by the script that is run
  std::map<std::string, std::vector<std::string>> mistakes_;
};

}  // namespace

std::vector<std::string> make_ids_unique(Config& config) {
  IdMaker maker(config);
  maker.visit(config.root);
  return std::move(maker.warnings);
}

std::vector<std::string> find_mistakes(const Config& config) {
  std::vector<std::string> mistakes;
  std::map<std::string, SourcePlace> known;
  for (const auto& [group, command] : all_commands(config)) {
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
  std::set<std::string> names;
  for (const ScriptConfig& script : config.scripts) {
    if (names.insert(script.name).second) continue;
    mistakes.push_back(script.place.text() + ": expected another name: there are two scripts \"" +
                       script.name + "\"");
  }
  return mistakes;
}

std::map<std::string, std::vector<std::string>> find_script_mistakes(const Config& config) {
  return ScriptChecker(config).check();
}

}  // namespace marco::procman
