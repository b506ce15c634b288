#include "procman/process/lone_deputy.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "procman/process/descriptor.hpp"

namespace marco::procman {

LoneDeputy::LoneDeputy(const std::string& config_path,
                       const std::string& lcm_url,
                       bool quiet,
                       bool accept_any_orders) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "marco-procman-deputy";
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw_errno("fork");
  if (pid_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  setpgid(0, 0);  // a ^C at the terminal is the sheriff's to handle
  if (quiet) {
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
      dup2(nothing, standard);
    }
  }
  if (!lcm_url.empty()) setenv("LCM_DEFAULT_URL", lcm_url.c_str(), 1);
  execl(program.c_str(), program.c_str(), "-i", "localhost", "--script", config_path.c_str(),
        accept_any_orders ? "--accept-any-orders" : nullptr, nullptr);
  std::perror(program.c_str());
  _exit(1);
}

void LoneDeputy::ask_to_end() const {
  if (pid_ > 0) kill(pid_, SIGTERM);
}

bool LoneDeputy::has_ended() {
  if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = 0;
  return pid_ == 0;
}

LoneDeputy::~LoneDeputy() {
  if (has_ended()) return;
  ask_to_end();
  waitpid(pid_, nullptr, 0);
}

}  // namespace marco::procman
