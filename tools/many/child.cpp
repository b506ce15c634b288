#include "tools/many/child.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

namespace marco::many {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

std::filesystem::path sibling_path(const char* name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

pid_t start_child(const std::filesystem::path& program,
                  std::vector<std::string> arguments,
                  const std::filesystem::path& output) {
  std::string name = program.string();
  std::vector<char*> argv{name.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot start " + name);
  if (child > 0) return child;
  constexpr int kNotStarted = 127;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg)
  const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  if (getppid() == parent) execv(name.c_str(), argv.data());
  _exit(kNotStarted);
}

ChildEnd wait_for_child(pid_t pid) {
  ChildEnd end;
  int status = 0;
  rusage used{};
  end.pid = wait4(pid, &status, 0, &used);
  if (end.pid <= 0) return {};
  end.cpu_s = seconds(used.ru_utime) + seconds(used.ru_stime);
  if (WIFSIGNALED(status)) {
    end.signal = WTERMSIG(status);
  } else {
    end.exit_code = WEXITSTATUS(status);
  }
  return end;
}

}  // namespace marco::many
