#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace marco::many {

/// How a program ended.
struct ChildEnd {
  pid_t pid = -1;
  int exit_code = 0;  ///< where no signal ended it
  int signal = 0;
  double cpu_s = 0.0;  ///< with that of its own children
};

/// A program of ours in this program's folder.
std::filesystem::path sibling_path(const char* name);

/// Starts a program, both outputs appended to a file. It is killed when this process ends before
/// it: what it works on may be begun again at once.
/// @throws std::runtime_error where there are no processes left.
pid_t start_child(const std::filesystem::path& program,
                  std::vector<std::string> arguments,
                  const std::filesystem::path& output);

/// Waits for one child, or for any (-1). @returns pid -1 where there is none, or a signal came.
ChildEnd wait_for_child(pid_t pid);

}  // namespace marco::many
