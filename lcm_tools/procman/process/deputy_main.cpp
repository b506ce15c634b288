#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/state_folder.hpp"
#include "lcm_tools/procman/config.hpp"
#include "lcm_tools/procman/process/deputy_process.hpp"
#include "lcm_tools/procman/process/folders.hpp"

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

namespace {

std::string host_name() {
  char name[256] = "localhost";
  gethostname(name, sizeof name - 1);
  return name;
}

void append_to(const std::string& path) {
  const procman::Descriptor log(
      open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (!log.is_open()) procman::throw_errno("cannot write " + path);
  dup2(log.get(), STDOUT_FILENO);
  dup2(log.get(), STDERR_FILENO);
}

std::set<std::string> execs_of(const std::vector<std::string>& scripts) {
  std::set<std::string> execs;
  for (const std::string& path : scripts) {
    for (const procman::PlacedCommand& placed : all_commands(procman::load_config(path))) {
      execs.insert(placed.command.wire_exec());
    }
  }
  return execs;
}

/// The command line of a deputy.
struct Arguments {
  procman::DeputyProcessOptions options;
  std::string log;
  std::vector<std::string> scripts;
  bool accept_any = false;
  bool verbose = false;
  std::string runtime_folder = procman::default_runtime_folder();
  std::string output_folder = procman::default_output_folder();
};

void describe(process::CommandLine& app, Arguments& arguments) {
  procman::DeputyProcessOptions& options = arguments.options;
  options.state.deputy_id = host_name();
  app.add_option("-i,--id", options.state.deputy_id, "name of this deputy").shows_default();
  app.add_option("-l,--log", arguments.log, "append the deputy's own messages to this file");
  app.add_option("-u,--lcmurl,--lcm-url", options.lcm_url,
                 "default: LCM_DEFAULT_URL, or this host only");
  app.add_option("--script", arguments.scripts,
                 "procman file whose exec strings may be started; repeatable")
      .existing_file()
      .repeatable();
  app.add_flag("--accept-any-orders", arguments.accept_any,
               "obey every sheriff: anyone who can send to this LCM network can then run any "
               "program as you");
  app.add_option("--runtime-folder", arguments.runtime_folder,
                 "for the sockets that let a restarted deputy find running commands")
      .shows_default();
  app.add_option("--output-folder", arguments.output_folder,
                 "for a file per command with all its output")
      .shows_default();
  app.add_option("--output-bytes", options.runs.max_file_bytes,
                 "a longer output file becomes COMMAND.log.1, replacing the previous one")
      .positive()
      .shows_default();
  app.add_option("--output-rate", options.runs.output_bytes_per_s, "bytes/s of PM_OUTPUT, at most")
      .positive()
      .shows_default();
  app.add_option("--max-crashes", options.state.max_crashes,
                 "consecutive short runs after which auto_respawn gives up")
      .positive()
      .shows_default();
  app.add_flag("-v,--verbose", arguments.verbose, "say more");
}

/// The commands' PATH begins with the folder of this program.
void find_own_programs(procman::DeputyProcessOptions& options) {
  const std::filesystem::path home = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  options.runs.keeper_program = home / "marco-procman-keeper";
  const char* path = std::getenv("PATH");
  setenv("PATH", (home.string() + ":" + (path != nullptr ? path : "")).c_str(), 1);
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-procman-deputy", [&] {
    process::CommandLine app(
        "Runs and watches commands for procman sheriffs. By default it runs only commands from its "
        "own --script files, and stops none because a sheriff leaves it out.");
    Arguments arguments;
    describe(app, arguments);
    if (const auto code = app.parse(argc, argv)) return *code;
    procman::DeputyProcessOptions& options = arguments.options;
    options.state.allowed_execs.reset();
    if (!arguments.accept_any) options.state.allowed_execs = execs_of(arguments.scripts);
    const std::string name = process::file_name_of(options.state.deputy_id);
    options.runs.runtime_folder = std::filesystem::absolute(arguments.runtime_folder) / name;
    options.runs.output_folder = std::filesystem::absolute(arguments.output_folder) / name;
    find_own_programs(options);
    if (!arguments.log.empty()) append_to(arguments.log);
    process::start_logging("marco-procman-deputy", arguments.verbose ? "debug" : "info");
    if (!arguments.accept_any && options.state.allowed_execs->empty()) {
      std::fputs(
          "marco-procman-deputy: starts nothing: it has no --script with commands, and "
          "no --accept-any-orders\n",
          stderr);
    }
    return procman::DeputyProcess(std::move(options)).run();
  });
}
