#include "lcm_tools/procman/wire.hpp"

#include <sys/wait.h>

#include <cstring>

namespace marco::procman {

std::string describe_exit(int raw_status) {
  if (WIFSIGNALED(raw_status)) {
    return "killed by signal " + std::to_string(WTERMSIG(raw_status)) + " (" +
           strsignal(WTERMSIG(raw_status)) + ")";
  }
  return "exit " + std::to_string(WEXITSTATUS(raw_status));
}

}  // namespace marco::procman
