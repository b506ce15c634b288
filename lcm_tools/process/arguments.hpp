#pragma once

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "lcm_tools/process/command_line.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"

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
void add_print_config(CommandLine& app, ConfigArguments& arguments);

/// Adds --lcm-url: the network, as LcmBus takes it.
void add_lcm_url(CommandLine& app, std::string& lcm_url);

/// Adds --log-level, for start_logging. What `level` holds is the default.
void add_log_level(CommandLine& app, std::string& level);

/// Adds --config --lcm-url --log-level --print-config --advanced to `app`.
void add_common_arguments(CommandLine& app, CommonArguments& arguments);

/// Where --print-config is given, prints the options. @returns whether the program is done by that
template <class Options>
bool prints_config(const ConfigArguments& arguments, const Options& options) {
  if (!arguments.print_config) return false;
  std::fputs(print_options(options, arguments.printed()).c_str(), stdout);
  return true;
}

/// Parses the command line of a program that needs inputs: they are not required with
/// --print-config, which this adds. @param config_path  an option of `app`
/// @returns as CommandLine::parse
template <class Options>
std::optional<int> parse_inputs(CommandLine& app,
                                Option inputs,
                                const std::string& config_path,
                                int argc,
                                const char* const* argv) {
  ConfigArguments arguments;
  add_print_config(app, arguments);
  inputs.required(std::none_of(
      argv, argv + argc, [](const char* word) { return std::string(word) == "--print-config"; }));
  if (const auto code = app.parse(argc, argv)) return code;
  if (!arguments.print_config) return std::nullopt;
  prints_config(arguments, load_options<Options>(config_path));
  return kExitDone;
}

/// Sets the log level and the common log format (stderr, wall-clock times).
void start_logging(const std::string& process, const std::string& level);

/// Flushes stdout. @throws std::runtime_error when it could not be written, e.g. on a full disk.
void finish_stdout();

/// Runs the body of main and finishes stdout. An exception becomes a message on stderr and
/// kExitFailed, a UsageError kExitUsage. An interrupted command (catch_interrupts) returns
/// kExitSignal + the signal's number.
int run_main(const std::string& process, const std::function<int()>& body);

}  // namespace marco::process
