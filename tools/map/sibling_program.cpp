#include "tools/map/sibling_program.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <stdexcept>

namespace marco {

namespace {

std::filesystem::path beside_this_program(const char* name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace

bool has_sibling(const char* name) { return std::filesystem::exists(beside_this_program(name)); }

int run_sibling(const char* name, std::vector<std::string> arguments) {
  std::string program = beside_this_program(name).string();
  std::vector<char*> argv{program.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  constexpr int kNotStarted = 127;
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) {
    // Set before anything runs: a parent that is killed now leaves no child behind, either.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == parent) execv(program.c_str(), argv.data());
    _exit(kNotStarted);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child ||
      (WIFEXITED(status) && WEXITSTATUS(status) == kNotStarted)) {
    throw std::runtime_error("cannot start " + program);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace marco
