#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/log/commands.hpp"
#include "lcm_tools/log/mcap_translator.hpp"
#include "lcm_tools/process/command_line.hpp"

namespace marco::logs {

/// A format of `export`.
struct ExportFormat {
  std::string name;                  ///< as given to --format
  std::vector<std::string> endings;  ///< of OUT that select it without --format: ".csv"
  std::function<void(const ExportArguments&)> write;
  /// Adds its own options to `export`; may be empty.
  std::function<void(process::CommandLine&)> add_options = {};
};

/// What a program adds to the commands that lcm_tools has for every LCM user.
struct Extensions {
  std::vector<ExportFormat> formats;
  MakeMcapTranslator make_mcap_translator;
  std::vector<std::function<void(process::CommandLine&)>> commands;  ///< each adds a subcommand
  std::vector<std::string_view> order_channels;  ///< left out by `play`, besides lcm_tools' own
  /// Explains a file that holds no LCM event, with its path. Empty: "PATH: has no complete LCM
  /// event".
  std::function<std::string(const std::string& path)> explain_no_log;
  /// What `info` says of a file that is no LCM log: see InfoArguments::describe.
  std::function<std::optional<std::string>(const std::string& path, Format format)> describe = {};
};

/// The body of main: parses the command line and runs the command. @returns the exit code.
int run_log_program(int argc, char** argv, const Extensions& extensions);

/// Adds -f,--force to a subcommand.
void add_force(process::CommandLine& command, Existing& existing);

}  // namespace marco::logs
