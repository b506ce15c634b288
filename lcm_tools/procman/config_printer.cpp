#include "lcm_tools/procman/config.hpp"

namespace marco::procman {
namespace {

std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '\n':
        out += "\\n";
        break;
      case '\r':
        out += "\\r";
        break;
      case '\t':
        out += "\\t";
        break;
      case '"':
      case '\\':
        out += '\\';
        [[fallthrough]];
      default:
        out += c;
    }
  }
  return out + "\"";
}

void print_command(const CommandConfig& command, const std::string& indent, std::string& out) {
  const CommandConfig defaults;
  const auto line = [&](const char* key, const std::string& value) {
    out += indent + "  " + key + " = " + value + ";\n";
  };
  const std::string& id = command.label.empty() ? command.id : command.label;
  out += indent + "cmd " + (id.empty() ? "" : in_quotes(id) + " ") + "{\n";
  line("exec", in_quotes(command.exec));
  if (!command.deputy.empty()) line("deputy", in_quotes(command.deputy));
  if (command.auto_respawn) line("auto_respawn", "\"true\"");
  if (command.stop_signal != defaults.stop_signal) {
    line("stop_signal", std::to_string(command.stop_signal));
  }
  if (command.stop_time_allowed_s != defaults.stop_time_allowed_s) {
    line("stop_time_allowed", std::to_string(command.stop_time_allowed_s));
  }
  if (!command.environment.empty()) line("environment", in_quotes(command.environment));
  if (!command.working_directory.empty()) {
    line("working_directory", in_quotes(command.working_directory));
  }
  out += indent + "}\n";
}

// Recursive as the groups are.
void print_members(const GroupConfig& group, const std::string& indent, std::string& out) {
  for (const CommandConfig& command : group.commands) print_command(command, indent, out);
  for (const GroupConfig& inner : group.groups) {
    out += indent + "group " + in_quotes(inner.name) + " {\n";
    print_members(inner, indent + "  ", out);
    out += indent + "}\n";
  }
}

std::string target_text(const Target& target) {
  if (target.kind == TargetKind::everything) return "everything";
  return (target.kind == TargetKind::command ? "cmd " : "group ") + in_quotes(target.name);
}

std::string condition_text(const WaitCondition& wait, const char* status_word) {
  std::string out = wait.what == WaitFor::publishing ? "publishing " + in_quotes(wait.channel)
                    : wait.what == WaitFor::running  ? std::string(status_word) + "\"running\""
                                                     : std::string(status_word) + "\"stopped\"";
  if (wait.timeout_ms) {
    out += " timeout ms " + std::to_string(*wait.timeout_ms) + " then " +
           (wait.continue_after_timeout ? "continue" : "abort");
  }
  return out;
}

std::string action_text(const ScriptAction& action) {
  const char* word = "start ";
  switch (action.kind) {
    case ActionKind::wait_ms:
      return "wait ms " + std::to_string(action.wait_ms);
    case ActionKind::run_script:
      return "run_script " + in_quotes(action.script);
    case ActionKind::wait_for:
      return "wait " + target_text(action.target) + " " + condition_text(*action.wait, "status ");
    case ActionKind::stop:
      word = "stop ";
      break;
    case ActionKind::restart:
      word = "restart ";
      break;
    case ActionKind::start:
      break;
  }
  return word + target_text(action.target) +
         (action.wait ? " wait " + condition_text(*action.wait, "") : "");
}

}  // namespace

std::string print_config(const Config& config) {
  std::string out;
  for (const Include& include : config.includes)
    out += "include " + in_quotes(include.path) + ";\n";
  print_members(config.root, "", out);
  for (const ScriptConfig& script : config.scripts) {
    out += "script " + in_quotes(script.name) + " {\n";
    for (const ScriptAction& action : script.actions) out += "  " + action_text(action) + ";\n";
    out += "}\n";
  }
  return out;
}

}  // namespace marco::procman
