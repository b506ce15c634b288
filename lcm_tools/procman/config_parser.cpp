#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/config_lexer.hpp"
#include "lcm_tools/procman/exec_line.hpp"
#include "lcm_tools/procman/group_index.hpp"

namespace marco::procman {
namespace {

// No robot nests deeper, and a hostile file must not overflow the stack.
constexpr int kMaxDepth = 100;

class Parser {
 public:
  Parser(const std::string& text, std::string file) : lexer_(text, std::move(file)) { advance(); }

  Config parse() {
    Config config;
    while (now_.kind != TokenKind::end) {
      const SourcePlace place = now_.place;
      if (take_word("cmd")) {
        parse_command(config.root, "", place);
      } else if (take_word("group")) {
        parse_group(config.root, "", 1);
      } else if (take_word("script")) {
        config.scripts.push_back(parse_script(place));
        const auto [known, is_new] = scripts_.try_emplace(config.scripts.back().name, place);
        if (!is_new) {
          throw ConfigError(place, "expected another name: there already is a script \"" +
                                       known->first + "\" at " + known->second.text());
        }
      } else if (take_word("include")) {
        config.includes.push_back({take_string("the path of a file"), place});
        take_symbol(";");
      } else {
        fail("'cmd', 'group', 'script' or 'include'");
      }
    }
    return config;
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw ConfigError(now_.place, "expected " + expected + ", got " + now_.description());
  }

  void advance() { now_ = lexer_.next(); }

  bool take_word(const char* word) {
    if (now_.kind != TokenKind::identifier || now_.text != word) return false;
    advance();
    return true;
  }

  bool sees_symbol(const char* symbol) const {
    return now_.kind == TokenKind::symbol && now_.text == symbol;
  }

  void take_symbol(const char* symbol) {
    if (!sees_symbol(symbol)) fail("'" + std::string(symbol) + "'");
    advance();
  }

  std::string take_string(const std::string& expected) {
    if (now_.kind != TokenKind::string) fail(expected + " in double quotes");
    std::string text = now_.text;
    advance();
    return text;
  }

  std::string take_name(const std::string& expected) {
    if (now_.kind == TokenKind::string && now_.text.empty()) fail(expected + " that is not empty");
    return take_string(expected);
  }

  int take_integer(const std::string& expected, int min, int max) {
    int value = 0;
    const char* end = now_.text.data() + now_.text.size();
    const bool good = now_.kind == TokenKind::integer &&
                      std::from_chars(now_.text.data(), end, value).ec == std::errc() &&
                      value >= min && value <= max;
    if (!good) {
      fail(expected + " (a whole number from " + std::to_string(min) + " to " +
           std::to_string(max) + ")");
    }
    advance();
    return value;
  }

  void parse_command(GroupConfig& group, const std::string& path, const SourcePlace& place) {
    CommandConfig command;
    command.place = place;
    std::string stated_group;
    if (now_.kind == TokenKind::string) {
      if (now_.text.find('/') != std::string::npos) fail("a command id without '/'");
      command.id = take_string("a command id");
    }
    take_symbol("{");
    while (!sees_symbol("}")) parse_attribute(command, stated_group);
    if (command.exec.empty()) fail("an attribute 'exec' that is not empty in this command");
    if (!stated_group.empty() && stated_group != path) {
      throw ConfigError(place, "expected the attribute 'group' to name the command's own group ('" +
                                   path + "'), got '" + stated_group + "'");
    }
    take_symbol("}");
    group.commands.push_back(std::move(command));
  }

  void parse_attribute(CommandConfig& command, std::string& stated_group) {
    const Token key = now_;
    if (key.kind != TokenKind::identifier) fail("an attribute or '}'");
    advance();
    take_symbol("=");
    const SourcePlace value_place = now_.place;
    if (key.text == "exec") {
      command.exec = take_name("the command line");
    } else if (key.text == "deputy" || key.text == "host") {
      command.deputy = take_string("a deputy's id");
    } else if (key.text == "auto_respawn") {
      command.auto_respawn = is_yes(take_string("true or false"));
    } else if (key.text == "stop_signal") {
      command.stop_signal = take_integer("the number of a signal", 1, kMaxSignal);
    } else if (key.text == "stop_time_allowed") {
      command.stop_time_allowed_s = take_integer("seconds", 1, 1000000);
    } else if (key.text == "group") {
      stated_group = take_string("a group");
    } else if (key.text == "environment") {
      command.environment = take_string("NAME=value words");
      if (!is_only_assignments(command.environment)) {
        throw ConfigError(value_place, "expected words of the form NAME=value, got \"" +
                                           command.environment + "\"");
      }
    } else if (key.text == "working_directory") {
      command.working_directory = take_string("a folder");
    } else {
      throw ConfigError(
          key.place,
          "expected exec, deputy, host, auto_respawn, stop_signal, stop_time_allowed, "
          "group, environment or working_directory, got '" +
              key.text + "'");
    }
    take_symbol(";");
  }

  // The public procman's rule: everything but these two is false.
  static bool is_yes(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return text == "true" || text == "yes";
  }

  void parse_group(GroupConfig& parent, const std::string& parent_path, int depth) {
    if (depth > kMaxDepth) fail("groups nested at most " + std::to_string(kMaxDepth) + " deep");
    if (now_.kind == TokenKind::string && now_.text.find('/') != std::string::npos) {
      fail("a group name without '/'");
    }
    const std::string name = take_name("a group name");
    if (name.find_first_not_of(" \t") == std::string::npos) fail("a group name that is not blank");
    const std::string path = group_path(parent_path, name);
    GroupConfig& group = groups_.open(parent, name, path);
    take_symbol("{");
    while (!sees_symbol("}")) {
      const SourcePlace place = now_.place;
      if (take_word("cmd")) {
        parse_command(group, path, place);
      } else if (take_word("group")) {
        parse_group(group, path, depth + 1);
      } else {
        fail("'cmd', 'group' or '}'");
      }
    }
    take_symbol("}");
  }

  ScriptConfig parse_script(const SourcePlace& place) {
    ScriptConfig script;
    script.place = place;
    script.name = take_name("a script name");
    take_symbol("{");
    while (!sees_symbol("}")) script.actions.push_back(parse_action());
    take_symbol("}");
    return script;
  }

  ScriptAction parse_action() {
    ScriptAction action;
    action.place = now_.place;
    if (take_word("start")) {
      parse_order(action, ActionKind::start);
    } else if (take_word("stop")) {
      parse_order(action, ActionKind::stop);
    } else if (take_word("restart")) {
      parse_order(action, ActionKind::restart);
    } else if (take_word("wait")) {
      parse_wait(action);
    } else if (take_word("run_script")) {
      action.kind = ActionKind::run_script;
      action.script = take_name("a script name");
    } else {
      fail("'start', 'stop', 'restart', 'wait', 'run_script' or '}'");
    }
    take_symbol(";");
    return action;
  }

  void parse_order(ScriptAction& action, ActionKind kind) {
    action.kind = kind;
    if (take_word("everything")) {
      action.target.kind = TargetKind::everything;
    } else if (!parse_target(action.target)) {
      fail("'everything', 'cmd' or 'group'");
    }
    if (!take_word("wait")) {
      if (!sees_symbol(";")) fail("'wait' or ';'");
      return;
    }
    action.wait.emplace();
    if (take_word("publishing")) {
      action.wait->what = WaitFor::publishing;
      action.wait->channel = take_name("a channel");
    } else {
      parse_status(*action.wait);
    }
    parse_timeout(*action.wait);
  }

  void parse_wait(ScriptAction& action) {
    if (take_word("ms")) {
      action.kind = ActionKind::wait_ms;
      action.wait_ms = take_integer("milliseconds", 0, 2147483647);
      return;
    }
    action.kind = ActionKind::wait_for;
    if (!parse_target(action.target)) fail("'ms', 'cmd' or 'group'");
    action.wait.emplace();
    if (take_word("publishing")) {
      action.wait->what = WaitFor::publishing;
      action.wait->channel = take_name("a channel");
    } else if (take_word("status")) {
      parse_status(*action.wait);
    } else {
      fail("'status' or 'publishing'");
    }
    parse_timeout(*action.wait);
  }

  bool parse_target(Target& target) {
    if (take_word("cmd")) {
      target = {TargetKind::command, take_name("a command id")};
      return true;
    }
    if (take_word("group")) {
      target = {TargetKind::group, take_name("a group name")};
      return true;
    }
    return false;
  }

  void parse_status(WaitCondition& wait) {
    if (now_.kind != TokenKind::string || (now_.text != "running" && now_.text != "stopped")) {
      fail("\"running\" or \"stopped\"");
    }
    wait.what = now_.text == "running" ? WaitFor::running : WaitFor::stopped;
    advance();
  }

  void parse_timeout(WaitCondition& wait) {
    if (!take_word("timeout")) return;
    if (!take_word("ms")) fail("'ms'");
    wait.timeout_ms = take_integer("milliseconds", 0, 2147483647);
    if (!take_word("then")) fail("'then'");
    wait.continue_after_timeout = take_word("continue");
    if (!wait.continue_after_timeout && !take_word("abort")) fail("'continue' or 'abort'");
  }

  ConfigLexer lexer_;
  Token now_;
  GroupIndex groups_;
  std::map<std::string, SourcePlace> scripts_;
};

}  // namespace

Config parse_config(const std::string& text, const std::string& file) {
  return Parser(text, file).parse();
}

}  // namespace marco::procman
