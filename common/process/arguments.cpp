#include "common/process/arguments.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace marco::process {

void add_common_arguments(CLI::App& app, CommonArguments& arguments) {
  app.add_option("--config", arguments.config_path, "TOML file; unknown keys are refused")
      ->check(CLI::ExistingFile);
  app.add_option("--lcm-url", arguments.lcm_url, "default: LCM_DEFAULT_URL, or this host only");
  app.add_option("--log-level", arguments.log_level, "trace, debug, info, warn, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_flag("--print-config", arguments.print_config, "print the config in force and exit");
}

std::optional<int> parse_arguments(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& stop) {
    return app.exit(stop);
  }
  return std::nullopt;
}

void start_logging(const std::string& process, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(process));
  spdlog::set_pattern("%H:%M:%S.%e %n %^%l%$ %v");
  spdlog::set_level(spdlog::level::from_str(level));
}

int run_main(const std::string& process, const std::function<int()>& body) {
  try {
    return body();
  } catch (const std::exception& failure) {
    fprintf(stderr, "%s: %s\n", process.c_str(), failure.what());
    return 1;
  }
}

}  // namespace marco::process
