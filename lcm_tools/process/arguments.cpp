#include "lcm_tools/process/arguments.hpp"

#include <fcntl.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco::process {

void add_lcm_url(CommandLine& app, std::string& lcm_url) {
  app.add_option("--lcm-url", lcm_url, "default: LCM_DEFAULT_URL, or this host only");
}

void add_log_level(CommandLine& app, std::string& level) {
  app.add_option("--log-level", level, "trace, debug, info, warn, error or off")
      .one_of({"trace", "debug", "info", "warn", "error", "off"})
      .shows_default();
}

void add_common_arguments(CommandLine& app, CommonArguments& arguments) {
  app.add_option("--config", arguments.config_path, "TOML file; unknown keys are refused")
      .existing_file();
  add_lcm_url(app, arguments.lcm_url);
  add_log_level(app, arguments.log_level);
  add_print_config(app, arguments);
}

void add_print_config(CommandLine& app, ConfigArguments& arguments) {
  const auto print = app.add_flag("--print-config", arguments.print_config,
                                  "print the effective settings with descriptions, and exit");
  app.add_flag("--advanced", arguments.advanced, "with --print-config: include the rare settings")
      .needs(print);
}

namespace {

/// What is logged may hold others' words.
class PrintablePayload : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message,
              const std::tm&,
              spdlog::memory_buf_t& to) override {
    const std::string text =
        printable({message.payload.data(), message.payload.size()}, Newline::set_in);
    to.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintablePayload>();
  }
};

}  // namespace

void start_logging(const std::string& process, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(process));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintablePayload>('*').set_pattern("%H:%M:%S.%e %n %^%l%$ %*");
  spdlog::set_formatter(std::move(formatter));
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
    print(stderr, "%s: %s\n", process.c_str(), printable(failure.what(), Newline::set_in).c_str());
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
    print(stderr, "%s: interrupted; %s\n", process.c_str(), interrupted_outcome().c_str());
    return kExitSignal + interrupted_by();
  }
}

}  // namespace marco::process
