#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

/// The contents of a procman file (.procman, .cfg). The grammar is the public procman's, both
/// dialects (`deputy = "..."` and libbot2's `host = "..."`), with additions marked (+):
///
///     file    := { cmd | group | script | (+) "include" STRING ";" }
///     cmd     := "cmd" STRING "{" { KEY "=" value ";" } "}"
///     group   := "group" STRING "{" { cmd | group } "}"
///     script  := "script" STRING "{" { action } "}"
///     action  := ("start"|"stop"|"restart") target [ "wait" ( STATUS | (+) publishing ) [timeout]
///     ] ";"
///              | "wait" "ms" INT ";"
///              | "wait" ("cmd"|"group") STRING ( "status" STATUS | (+) publishing ) [timeout] ";"
///              | "run_script" STRING ";"
///     target  := "everything" | "cmd" STRING | "group" STRING
///     publishing := "publishing" CHANNEL-STRING
///     timeout := (+) "timeout" "ms" INT "then" ("continue" | "abort")
///     STATUS  := "\"running\"" | "\"stopped\""
///     KEY     := exec, deputy or host, auto_respawn, stop_signal, stop_time_allowed, group,
///                (+) environment, (+) working_directory
///
/// `#` starts a comment; strings know `\n \r \t \" \\` and end on their line, unless a backslash is
/// the last character of it: then the line end belongs to the string.
namespace marco::procman {

constexpr int kMaxSignal = 64;

/// Where something was read. All places are equal, so that configs compare by what they say.
struct SourcePlace {
  std::string file;
  int line = 0;    ///< from 1
  int column = 0;  ///< from 1, bytes

  std::string text() const;
  friend bool operator==(const SourcePlace& /*a*/, const SourcePlace& /*b*/) { return true; }
};

/// "FILE:LINE:COLUMN: expected ..., got ...".
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const SourcePlace& place, const std::string& what)
      : std::runtime_error(place.text() + ": " + what) {}
};

struct CommandConfig {
  std::string id;      ///< unique over all groups and deputies; no '/'
  std::string label;   ///< its id in the file, where make_ids_unique gave it another; else ""
  std::string exec;    ///< see exec_line.hpp
  std::string deputy;  ///< the id of the deputy that runs it
  bool auto_respawn = false;
  int stop_signal = 2;          ///< 1..kMaxSignal; 2 = SIGINT
  int stop_time_allowed_s = 7;  ///< >= 1, then SIGKILL
  std::string environment;  ///< NAME=value words, quoted as in exec; values are taken as they stand
  std::string working_directory;  ///< "" = the deputy's; $NAME is the deputy's variable
  SourcePlace place;

  /// The exec string that goes to a deputy, theirs or ours: environment words, then `env -C
  /// DIRECTORY` when one is given, then exec. The allow-list of a deputy holds these.
  std::string wire_exec() const;
  bool operator==(const CommandConfig&) const = default;
};

struct GroupConfig {
  std::string name;  ///< one part of the path, no '/'; "" only for the outermost
  std::vector<CommandConfig> commands;
  std::vector<GroupConfig> groups;

  bool operator==(const GroupConfig&) const = default;
};

enum class TargetKind { everything, command, group };

struct Target {
  TargetKind kind = TargetKind::everything;
  std::string name;  ///< command id, or group path "a/b", which means its subgroups too

  std::string text() const;
  bool operator==(const Target&) const = default;
};

enum class WaitFor { running, stopped, publishing };

struct WaitCondition {
  WaitFor what = WaitFor::running;
  std::string channel;                  ///< of `publishing`: a message on it since the action began
  std::optional<int> timeout_ms;        ///< none = for ever
  bool continue_after_timeout = false;  ///< else the script is aborted

  bool operator==(const WaitCondition&) const = default;
};

enum class ActionKind { start, stop, restart, wait_ms, wait_for, run_script };

struct ScriptAction {
  ActionKind kind = ActionKind::start;
  Target target;                      ///< of start, stop, restart, wait_for
  std::optional<WaitCondition> wait;  ///< of start, stop, restart; always there with wait_for
  int wait_ms = 0;                    ///< of wait_ms
  std::string script;                 ///< of run_script
  SourcePlace place;

  bool operator==(const ScriptAction&) const = default;
};

struct ScriptConfig {
  std::string name;
  std::vector<ScriptAction> actions;
  SourcePlace place;

  bool operator==(const ScriptConfig&) const = default;
};

struct Include {
  std::string path;  ///< as written: relative to the file that says it
  SourcePlace place;

  bool operator==(const Include&) const = default;
};

struct Config {
  std::vector<Include> includes;
  GroupConfig root;
  std::vector<ScriptConfig> scripts;

  bool operator==(const Config&) const = default;
};

/// A command and the path of the group it stands in.
struct PlacedCommand {
  std::string group;  ///< "drivers/cameras"; "" = none
  CommandConfig command;
};

/// @param file the name that errors carry.
/// @throws ConfigError at the first thing that is not of the grammar, unknown attributes included.
Config parse_config(const std::string& text, const std::string& file);

/// Text that parses to an equal Config. Comments are not kept.
std::string print_config(const Config& config);

/// Reads a file by its path. @throws std::runtime_error when it cannot.
using FileReader = std::function<std::string(const std::string& path)>;

/// Limits of a procman file with all that it includes.
inline constexpr std::size_t kMaxConfigBytes = std::size_t{16} << 20;
inline constexpr int kMaxConfigFiles = 256;
inline constexpr int kMaxIncludeDepth = 32;

/// Parses `path` and, in place, what it includes; groups of one name become one group. A file that
/// is included twice counts once.
/// @throws ConfigError, also for a file that includes itself and beyond the limits above.
Config load_config(const std::string& path, const FileReader& read_file);

/// As above, from the disk: regular files only.
Config load_config(const std::string& path);

/// All commands in the order of the file, groups before subgroups.
std::vector<PlacedCommand> all_commands(const Config& config);

/// libbot2's procman takes an id as a label that several commands may bear. Here the first keeps
/// it and the others become "ID (2)", "ID (3)", ...; a script that names the label means them all.
/// @returns a warning for each, with its place.
std::vector<std::string> make_ids_unique(Config& config);

/// Why a file cannot be used at all: a command without id or deputy, a duplicate id, a duplicate
/// script name. One line each, with its place; empty = good.
std::vector<std::string> find_mistakes(const Config& config);

/// Of a script, with those of the scripts that it runs: some lines of a file may mean 2^300.
inline constexpr int64_t kMostScriptActions = 100'000;

/// By script name, why it cannot be run: it names a missing command, group or script, runs itself,
/// has more than kMostScriptActions, or runs a script that cannot be run. All others can be run.
std::map<std::string, std::vector<std::string>> find_script_mistakes(const Config& config);

/// Adds a command, or replaces the one with its id, which may be in another group.
void put_command(Config& config, const PlacedCommand& placed);
/// @returns whether there was one.
bool remove_command(Config& config, const std::string& id);

/// The names in a group's path; needless slashes are ignored.
std::vector<std::string> path_parts(const std::string& path);

/// Whether `group` is `wanted` or within it; both as paths.
bool group_is_within(const std::string& group, const std::string& wanted);

const ScriptConfig* find_script(const Config& config, const std::string& name);

}  // namespace marco::procman
