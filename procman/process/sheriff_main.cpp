#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "common/process/arguments.hpp"
#include "common/process/exit_code.hpp"
#include "procman/process/lone_deputy.hpp"
#include "procman/process/screen.hpp"
#include "procman/process/sheriff_process.hpp"

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using procman::ScriptRunner;
using procman::SheriffProcess;

namespace {

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
};

void add_arguments(CLI::App& app, SheriffArguments& arguments) {
  app.add_option("config", arguments.config, "procman file")->check(CLI::ExistingFile);
  app.add_option("script_name,--script", arguments.script, "script of the file to run at once");
  app.add_flag("-n,--no-gui", arguments.no_screen, "no screen: run the script, print what happens");
  app.add_flag("-o,--observer", arguments.observer, "only watch")->excludes("--no-gui");
  app.add_flag("-l,--lone-ranger", arguments.lone, "with a deputy 'localhost' of its own inside")
      ->excludes("--observer");
  app.add_option("--on-script-complete", arguments.on_script_complete,
                 "what then: exit (the default without a screen) or observer")
      ->check(CLI::IsMember({"exit", "observer", "observe"}));
  app.add_flag("--accept-any-orders", arguments.accept_any_orders,
               "the deputy of -l runs what is not in the file, too: commands made on the screen");
  app.add_flag("--output", arguments.show_output, "without a screen: print the commands' output");
  app.add_option("-u,--lcmurl,--lcm-url", arguments.lcm_url,
                 "default: LCM_DEFAULT_URL, or this host only");
}

/// @returns 1 after saying why this cannot work, else 0.
int check(const SheriffArguments& arguments, const procman::Config& config) {
  process::require_usage(!arguments.config.empty() || arguments.observer,
                         "a procman file is needed, unless as observer (-o)");
  process::require_usage(!arguments.no_screen || !arguments.script.empty(),
                         "-n needs the name of a script to run");
  std::vector<std::string> mistakes = procman::find_mistakes(config);
  if (!arguments.script.empty() && find_script(config, arguments.script) == nullptr) {
    std::string known;
    for (const procman::ScriptConfig& script : config.scripts) known += " \"" + script.name + "\"";
    mistakes.push_back("there is no script \"" + arguments.script + "\"; there are:" + known);
  }
  for (const std::string& mistake : mistakes) {
    std::fprintf(stderr, "marco-procman-sheriff: %s\n", mistake.c_str());
  }
  return mistakes.empty() ? 0 : 1;
}

/// Until what the script asked for last is done. @returns whether it is.
bool settle(SheriffProcess& sheriff) {
  const int64_t end_us = procman::monotonic_us() + kMaxSettlingUs;
  while (!sheriff.unsettled().empty() && procman::monotonic_us() < end_us) {
    if (sheriff.stop_signals() > 0) return false;
    sheriff.step(100'000, -1);
  }
  for (const std::string& line : sheriff.unsettled()) sheriff.note("not done: " + line);
  return sheriff.unsettled().empty();
}

int run_headless(SheriffProcess& sheriff, const SheriffArguments& arguments) {
  sheriff.on_event = [](const std::string& line) {
    std::puts(procman::printable(line).c_str());
    std::fflush(stdout);
  };
  if (arguments.show_output) {
    sheriff.on_output_line = [](const std::string& id, const std::string& line) {
      std::printf("%s| %s\n", id.c_str(), line.c_str());
      std::fflush(stdout);
    };
  }
  sheriff.run_script(arguments.script);
  while (sheriff.script()->state() == ScriptRunner::State::running) {
    if (sheriff.stop_signals() > 0) return 1;
    sheriff.step(100'000, -1);
  }
  if (sheriff.script()->state() == ScriptRunner::State::aborted || !settle(sheriff)) return 1;
  if (arguments.on_script_complete.starts_with("observe")) {
    sheriff.state().set_observer(true);
    while (sheriff.stop_signals() == 0) sheriff.step(200'000, -1);
  }
  return 0;
}

int run_screen(SheriffProcess& sheriff, const SheriffArguments& arguments) {
  procman::Screen screen(sheriff, arguments.config);
  if (!arguments.script.empty()) sheriff.run_script(arguments.script);
  bool script_over = arguments.script.empty();
  while (sheriff.stop_signals() == 0 && !screen.wants_to_end()) {
    sheriff.step(100'000, STDIN_FILENO);
    screen.step();
    if (script_over || sheriff.script() == nullptr) continue;
    script_over = sheriff.script()->state() != ScriptRunner::State::running;
    if (!script_over) continue;
    if (arguments.on_script_complete == "exit") break;
    if (!arguments.on_script_complete.empty()) sheriff.state().set_observer(true);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-procman-sheriff", [&] {
    CLI::App app("Tells procman deputies what to run, by a procman file and its scripts");
    SheriffArguments arguments;
    add_arguments(app, arguments);
    if (const auto code = process::parse_arguments(app, argc, argv)) return *code;
    const procman::Config config =
        arguments.config.empty() ? procman::Config{} : procman::load_config(arguments.config);
    if (check(arguments, config) != 0) return 1;
    std::unique_ptr<procman::LoneDeputy> lone;
    if (arguments.lone) {
      lone = std::make_unique<procman::LoneDeputy>(
          arguments.config, arguments.lcm_url, !arguments.no_screen, arguments.accept_any_orders);
    }
    SheriffProcess sheriff(arguments.lcm_url, config, arguments.observer);
    const int code =
        arguments.no_screen ? run_headless(sheriff, arguments) : run_screen(sheriff, arguments);
    if (lone) lone->ask_to_end();
    for (int seen = sheriff.stop_signals(); lone && !lone->has_ended();) {
      sheriff.step(100'000, -1);
      if (sheriff.stop_signals() == seen) continue;
      seen = sheriff.stop_signals();
      lone->ask_to_end();
    }
    return code;
  });
}
