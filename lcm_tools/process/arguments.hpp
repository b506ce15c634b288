#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "lcm_tools/process/printed.hpp"

namespace marco::process {

/// `--print-config` and what it shows.
struct ConfigArguments {
  bool print_config = false;  ///< print the config in force and exit
  bool advanced = false;      ///< the advanced settings, too

  Printed printed() const { return advanced ? Printed::all : Printed::common; }
};

/// Options of every process. Algorithm settings are in the config, not on the command line.
struct CommonArguments : ConfigArguments {
  std::string config_path;         ///< TOML; "" = the defaults
  std::string lcm_url;             ///< "" = effective_lcm_url
  std::string log_level = "info";  ///< trace debug info warn error off
};

/// Adds --print-config and --advanced to `app`.
void add_print_config(CLI::App& app, ConfigArguments& arguments);

/// Adds --config --lcm-url --log-level --print-config --advanced to `app`.
void add_common_arguments(CLI::App& app, CommonArguments& arguments);

/// Parses the command line. Prints help, the version (--version) or the mistake, with a suggestion
/// for an unknown word. @returns an exit code when the program should end now: kExitDone,
/// kExitUsage.
std::optional<int> parse_arguments(CLI::App& app, int argc, const char* const* argv);

/// Sets the log level and the common log format (stderr, wall-clock times).
void start_logging(const std::string& process, const std::string& level);

/// Flushes stdout. @throws std::runtime_error when it could not be written, e.g. on a full disk.
void finish_stdout();

/// Runs the body of main and finishes stdout. An exception becomes a message on stderr and
/// kExitFailed, a UsageError kExitUsage. An interrupted command (catch_interrupts) returns
/// kExitSignal + the signal's number.
int run_main(const std::string& process, const std::function<int()>& body);

}  // namespace marco::process
