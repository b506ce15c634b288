#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace marco::testing {

struct Outcome {
  int exit_code = 0;
  std::string output;  ///< stdout and stderr
};

/// Runs a command line of the shell to its end.
inline Outcome run(const std::string& command) {
  Outcome outcome;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char block[4096];
  for (std::size_t got = 0; (got = std::fread(block, 1, sizeof block, pipe)) > 0;) {
    outcome.output.append(block, got);
  }
  outcome.exit_code = WEXITSTATUS(pclose(pipe));
  return outcome;
}

/// marco-log in MARCO_BIN.
inline std::string log_program() {
  const char* folder = std::getenv("MARCO_BIN");
  return std::string(folder == nullptr ? "build/dev/bin" : folder) + "/marco-log";
}

inline Outcome run_log(const std::string& arguments) {
  return run(log_program() + " " + arguments);
}

}  // namespace marco::testing
