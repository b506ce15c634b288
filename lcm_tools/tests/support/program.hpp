#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace marco::testing {

/// A program of ours started as a user would; both outputs go to one file. Ended by the destructor.
class Program {
 public:
  /// @param name  of a program in MARCO_BIN, or one found in PATH when it has no "marco-" in front.
  Program(const std::string& name, std::vector<std::string> arguments, std::string output_path)
      : output_path_(std::move(output_path)) {
    const char* bin = std::getenv("MARCO_BIN");
    const bool ours = name.rfind("marco-", 0) == 0 && bin != nullptr;
    std::string path = ours ? std::string(bin) + "/" + name : name;
    std::vector<char*> argv{path.data()};
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      const int file = open(output_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(file, 1);
      dup2(file, 2);
      execvp(path.c_str(), argv.data());
      _exit(127);
    }
  }
  ~Program() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const { ::kill(pid_, number); }
  pid_t pid() const { return pid_; }

  /// @returns the exit code; 128 + signal when one ended it; -1 when it still runs after the time.
  int wait(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return -1;
  }

 private:
  std::string output_path_;
  pid_t pid_ = -1;
};

}  // namespace marco::testing
