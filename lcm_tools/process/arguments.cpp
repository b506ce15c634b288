#include "lcm_tools/process/arguments.hpp"

#include <fcntl.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcm_tools/process/suggest.hpp"
#include "lcm_tools/process/version.hpp"

namespace marco::process {
namespace {

// The subcommand that was given, or the program itself.
const CLI::App& innermost(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : innermost(*given.back());
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

// CLI11's message, unless a word is unknown: then that is the mistake.
std::string mistake_of(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  for (const std::string& word : app.remaining(true)) {
    if (word.size() > 1 && word.front() == '-') {
      const std::string name = word.substr(0, word.find('='));
      return "unknown option '" + name + "'" + did_you_mean(name, option_names(command));
    }
    const std::vector<std::string> commands = command_names(command);
    if (commands.empty()) continue;
    return "unknown command '" + word + "'" + did_you_mean(word, commands);
  }
  return error.what();
}

}  // namespace

void add_common_arguments(CLI::App& app, CommonArguments& arguments) {
  app.add_option("--config", arguments.config_path, "TOML file; unknown keys are refused")
      ->check(CLI::ExistingFile);
  app.add_option("--lcm-url", arguments.lcm_url, "default: LCM_DEFAULT_URL, or this host only");
  app.add_option("--log-level", arguments.log_level, "trace, debug, info, warn, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  add_print_config(app, arguments);
}

void add_print_config(CLI::App& app, ConfigArguments& arguments) {
  auto* print = app.add_flag("--print-config", arguments.print_config,
                             "print the settings in force, with what they are, and exit");
  app.add_flag("--advanced", arguments.advanced, "with --print-config: the rare settings, too")
      ->needs(print);
}

std::optional<int> parse_arguments(CLI::App& app, int argc, const char* const* argv) {
  if (app.get_name().empty()) app.name(std::filesystem::path(argv[0]).filename());
  app.set_version_flag("--version", app.get_name() + " " + version(), "print the version and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& stop) {
    return app.exit(stop);
  } catch (const CLI::ParseError& mistake) {
    std::fprintf(stderr, "%s: %s\nTry %s --help\n", app.get_name().c_str(),
                 mistake_of(app, mistake).c_str(), app.get_name().c_str());
    return kExitUsage;
  }
  return std::nullopt;
}

void start_logging(const std::string& process, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(process));
  spdlog::set_pattern("%H:%M:%S.%e %n %^%l%$ %v");
  spdlog::set_level(spdlog::level::from_str(level));
}

void finish_stdout() {
  // A program started without a standard output has no reader.
  if (fcntl(STDOUT_FILENO, F_GETFD) < 0) return;
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return;
  // An earlier write that failed left its mark, but not its reason.
  throw std::runtime_error(std::string("standard output is not complete: ") +
                           (flushed || errno == 0 ? "a write failed" : std::strerror(errno)));
}

int run_main(const std::string& process, const std::function<int()>& body) {
  const auto told = [&](const std::exception& failure, int code) {
    fprintf(stderr, "%s: %s\n", process.c_str(), failure.what());
    return code;
  };
  try {
    const int code = body();
    finish_stdout();
    return code;
  } catch (const UsageError& mistake) {
    return told(mistake, kExitUsage);
  } catch (const std::exception& failure) {
    if (interrupted_by() == 0) return told(failure, kExitFailed);
    // The same Ctrl-C ended the programs that this one started: their complaints are no news.
    fprintf(stderr, "%s: interrupted; %s\n", process.c_str(), interrupted_outcome().c_str());
    return kExitSignal + interrupted_by();
  }
}

}  // namespace marco::process
