#include <cstdio>
#include <optional>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/procman/process/screen.hpp"
#include "lcm_tools/procman/process/sheriff_process.hpp"
#include "lcm_tools/procman/process/sheriff_session.hpp"

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using procman::ScriptRunner;
using procman::SheriffProcess;
using procman::SheriffSession;

namespace {

// A command that is restarted from outside stands still for a moment.
constexpr int64_t kNothingRunsUs = 2'000'000;
// Deputies answer within a second; the rest is for stubborn commands to be killed.
constexpr int64_t kMaxSettlingUs = 15'000'000;

struct SheriffArguments {
  std::string config;
  std::string script;
  std::string lcm_url;
  std::string on_script_complete;
  bool no_screen = false;
  bool observer = false;
  bool lone = false;
  bool show_output = false;
  bool accept_any_orders = false;
  bool check_free = false;
};

void add_arguments(process::CommandLine& app, SheriffArguments& arguments) {
  app.add_option("config", arguments.config, "procman file").existing_file();
  app.add_option("script_name,--script", arguments.script, "script of the file to run at once");
  app.add_flag("-n,--no-gui", arguments.no_screen, "no screen: run the script, print what happens");
  app.add_flag("-o,--observer", arguments.observer, "only watch").excludes("--no-gui");
  app.add_flag("-l,--lone-ranger", arguments.lone, "with a built-in deputy 'localhost'")
      .excludes("--observer");
  app.add_option("--on-script-complete", arguments.on_script_complete,
                 "exit or observer. Default without a screen: exit; with -l only when all commands "
                 "have ended")
      .one_of({"exit", "observer", "observe"});
  app.add_flag("--accept-any-orders", arguments.accept_any_orders,
               "the deputy of -l also runs commands that are not in the file, such as those "
               "created on the screen");
  app.add_flag("--check-free", arguments.check_free,
               "only check whether -l is possible: exit 0, or 1 with the reason");
  app.add_flag("--output", arguments.show_output, "without a screen: print the commands' output");
  app.add_option("-u,--lcmurl,--lcm-url", arguments.lcm_url,
                 "default: LCM_DEFAULT_URL, or this host only");
}

std::string names_of_scripts(const procman::Config& config) {
  std::string known;
  for (const procman::ScriptConfig& script : config.scripts) known += " \"" + script.name + "\"";
  return known.empty() ? "; the file has none" : "; there are:" + known;
}

/// @returns 1 after saying why this cannot work, else 0.
int check(const SheriffArguments& arguments, const procman::Config& config) {
  process::require_usage(!arguments.config.empty() || arguments.observer,
                         "a procman file is required, except as observer (-o)");
  process::require_usage(!arguments.observer || arguments.script.empty(),
                         "-o only watches: it runs no script");
  if (arguments.no_screen && arguments.script.empty()) {
    throw process::UsageError("without a screen (-n) a script is required" +
                              names_of_scripts(config));
  }
  std::vector<std::string> mistakes = procman::find_mistakes(config);
  if (!arguments.script.empty() && find_script(config, arguments.script) == nullptr) {
    mistakes.push_back("there is no script \"" + arguments.script + "\"" +
                       names_of_scripts(config));
  }
  const auto broken = procman::find_script_mistakes(config);
  if (const auto at = broken.find(arguments.script); at != broken.end()) {
    mistakes.push_back("script \"" + arguments.script + "\" cannot be run:");
    mistakes.insert(mistakes.end(), at->second.begin(), at->second.end());
  }
  for (const std::string& mistake : mistakes) {
    std::fprintf(stderr, "marco-procman-sheriff: %s\n", mistake.c_str());
  }
  return mistakes.empty() ? 0 : 1;
}

/// Problems of the file that do not keep it from being used.
std::vector<std::string> warnings_about(procman::Config& config) {
  std::vector<std::string> warnings = procman::make_ids_unique(config);
  for (const auto& [script, mistakes] : procman::find_script_mistakes(config)) {
    const std::string head = "script \"" + script + "\" cannot be run: ";
    for (const std::string& mistake : mistakes) {
      warnings.push_back(head + mistake);
    }
  }
  return warnings;
}

/// Waits until the script's last orders are done. @returns whether they are.
bool settle(SheriffProcess& sheriff, SheriffSession& session) {
  const int64_t end_us = procman::monotonic_us() + kMaxSettlingUs;
  while (!sheriff.unsettled().empty() && procman::monotonic_us() < end_us) {
    if (sheriff.stop_signals() > 0) return false;
    session.step(100'000, -1);
  }
  for (const std::string& line : sheriff.unsettled()) sheriff.log().note("not done: " + line);
  return sheriff.unsettled().empty();
}

void print_events(SheriffProcess& sheriff, const SheriffArguments& arguments) {
  sheriff.log().on_event = [](const std::string& line) {
    std::puts(procman::printable(line).c_str());
    std::fflush(stdout);
  };
  if (!arguments.show_output) return;
  sheriff.log().on_output_line = [](const std::string& id, const std::string& line) {
    std::printf("%s| %s\n", id.c_str(), line.c_str());
    std::fflush(stdout);
  };
}

/// A sheriff with its own deputy stays until its commands have ended, or a stop signal: they would
/// end with it.
void stay_with_what_runs(SheriffProcess& sheriff, SheriffSession& session) {
  const std::string running = sheriff.running_text();
  if (running.empty()) return;
  sheriff.log().note("the script is done; these keep running: " + running + ". ^C, or kill " +
                     std::to_string(getpid()) +
                     ", stops them; with --on-script-complete exit they end with the script");
  int64_t ran_us = procman::monotonic_us();
  while (sheriff.stop_signals() == 0 && procman::monotonic_us() - ran_us < kNothingRunsUs) {
    session.step(200'000, -1);
    if (!sheriff.running_text().empty()) ran_us = procman::monotonic_us();
  }
}

int run_headless(SheriffProcess& sheriff,
                 SheriffSession& session,
                 const SheriffArguments& arguments) {
  sheriff.script().run(arguments.script);
  while (sheriff.script().is_running()) {
    if (sheriff.stop_signals() > 0) return 1;
    session.step(100'000, -1);
  }
  const bool aborted = sheriff.script().state() == ScriptRunner::State::aborted;
  if (aborted || !settle(sheriff, session)) return 1;
  if (arguments.on_script_complete.starts_with("observe")) {
    sheriff.state().set_observer(true);
    while (sheriff.stop_signals() == 0) session.step(200'000, -1);
  } else if (arguments.on_script_complete.empty() && session.is_lone()) {
    stay_with_what_runs(sheriff, session);
  }
  return 0;
}

int run_screen(SheriffProcess& sheriff,
               SheriffSession& session,
               const SheriffArguments& arguments) {
  procman::Screen screen(sheriff, {arguments.config, session.is_lone()});
  if (!arguments.script.empty()) sheriff.script().run(arguments.script);
  bool script_over = arguments.script.empty();
  while (sheriff.stop_signals() == 0 && !screen.wants_to_end()) {
    session.step(100'000, STDIN_FILENO);
    screen.step();
    if (script_over || !sheriff.script().is_loaded()) continue;
    script_over = !sheriff.script().is_running();
    if (!script_over) continue;
    if (arguments.on_script_complete == "exit") break;
    if (!arguments.on_script_complete.empty()) sheriff.state().set_observer(true);
  }
  return 0;
}

std::optional<procman::LoneDeputyOptions> lone_options(const SheriffArguments& arguments) {
  if (!arguments.lone) return std::nullopt;
  return procman::LoneDeputyOptions{arguments.config, arguments.lcm_url,
                                    arguments.no_screen ? "" : procman::lone_deputy_log(),
                                    arguments.accept_any_orders};
}

int run(const SheriffArguments& arguments) {
  procman::Config config =
      arguments.config.empty() ? procman::Config{} : procman::load_config(arguments.config);
  const std::vector<std::string> warnings = warnings_about(config);
  if (!arguments.check_free && check(arguments, config) != 0) return 1;
  SheriffProcess sheriff(arguments.lcm_url, config, arguments.observer);
  if (arguments.lone || arguments.check_free) {
    const std::string rival = procman::find_lone_rival(sheriff);
    if (!rival.empty()) {
      std::fprintf(stderr, "marco-procman-sheriff: %s\n", procman::printable(rival).c_str());
      return 1;
    }
    if (arguments.check_free || sheriff.stop_signals() > 0) return 0;
  }
  if (arguments.no_screen) print_events(sheriff, arguments);
  for (const std::string& warning : warnings) sheriff.log().note("warning: " + warning);
  SheriffSession session(sheriff, lone_options(arguments));
  if (session.is_lone() && !arguments.no_screen) {
    sheriff.log().note(std::string("messages of deputy ") + procman::kLoneDeputyId + ": " +
                       procman::lone_deputy_log());
  }
  const int code = arguments.no_screen ? run_headless(sheriff, session, arguments)
                                       : run_screen(sheriff, session, arguments);
  session.end();
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-procman-sheriff", [&] {
    process::CommandLine app(
        "Orders procman deputies what to run, from a procman file and its scripts");
    SheriffArguments arguments;
    add_arguments(app, arguments);
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
