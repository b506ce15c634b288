#include "lcm_tools/recorder/logger_child.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <stdexcept>
#include <thread>

namespace marco::recorder {

LoggerChild::LoggerChild(const std::string& url,
                         const std::filesystem::path& folder,
                         const std::string& piece_mb) {
  const std::string split = "--split-mb=" + piece_mb, network = "--lcm-url=" + url,
                    file = folder / "live.lcm";
  const std::array words = {"lcm-logger", "-q", "-i", split.c_str(), network.c_str(), file.c_str()};
  std::array<char*, words.size() + 1> arguments = {};
  for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = const_cast<char*>(words[i]);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("lcm-logger: cannot start a process");
  if (pid_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGINT);
  if (getppid() != parent) _exit(1);
  execvp(arguments[0], arguments.data());
  _exit(kNotInstalled);
}

LoggerChild::~LoggerChild() { stop(Told::no); }

std::optional<int> LoggerChild::ended() {
  int status = 0;
  if (pid_ <= 0 || waitpid(pid_, &status, WNOHANG) == 0) return std::nullopt;
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

bool LoggerChild::ends_within(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (pid_ > 0 && !ended()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

void LoggerChild::stop(Told told) {
  constexpr double kOfItselfS = 0.5, kLongestS = 3.0;
  if (pid_ <= 0 || (told == Told::already && ends_within(kOfItselfS))) return;
  ::kill(pid_, SIGINT);
  if (ends_within(kLongestS)) return;
  ::kill(pid_, SIGKILL);
  ends_within(kLongestS);
}

}  // namespace marco::recorder
