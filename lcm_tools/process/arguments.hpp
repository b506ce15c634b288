#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

namespace marco::process {

/// What every process of Marco takes; there are no algorithm flags, those live in the config.
struct CommonArguments {
  std::string config_path;         ///< TOML; "" = the defaults
  std::string lcm_url;             ///< "" = effective_lcm_url
  std::string log_level = "info";  ///< trace debug info warn error off
  bool print_config = false;       ///< print the config in force and exit
};

/// Adds --config --lcm-url --log-level --print-config to `app`.
void add_common_arguments(CLI::App& app, CommonArguments& arguments);

/// Parses, printing help, the version (--version) or the mistake, with the nearest name where a
/// word is unknown. @returns an exit code when the program should end now: kExitDone or kExitUsage.
std::optional<int> parse_arguments(CLI::App& app, int argc, const char* const* argv);

/// Applies the log level and the one log format of all processes (stderr, monotonic enough for a
/// person).
void start_logging(const std::string& process, const std::string& level);

/// Flushes what was printed. @throws std::runtime_error when it could not be written: a full disk,
/// a device that refuses.
void finish_stdout();

/// The body of each main: runs it, finishes stdout, and turns any exception into a message on
/// stderr and kExitFailed, a UsageError into kExitUsage. A command that was interrupted
/// (catch_interrupts) ends with kExitSignal + the signal's number.
int run_main(const std::string& process, const std::function<int()>& body);

}  // namespace marco::process
